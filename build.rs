//! Compiles every shader under `glsl/` with shaderc, reflects the SPIR-V and writes `shaders.rs`: a module a program, with
//! typed bindings. A binding that is missing, renamed or used against its declaration does not compile.

#[path = "glsl/build/generate.rs"]
mod generate;
#[path = "glsl/build/reflect.rs"]
mod reflect;
#[path = "glsl/build/structs.rs"]
mod structs;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use generate::{Program, Stage};
use shaderc::{
    CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind, SourceLanguage, TargetEnv,
};

fn kind(extension: &str) -> Option<ShaderKind> {
    match extension {
        "vert" => Some(ShaderKind::Vertex),
        "frag" => Some(ShaderKind::Fragment),
        "comp" => Some(ShaderKind::Compute),
        _ => None,
    }
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("glsl/ is readable").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().and_then(|e| kind(e.to_str()?)).is_some() {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn options<'a>(shared: &'a str) -> CompileOptions<'a> {
    let mut options = CompileOptions::new().expect("shaderc starts");
    options.set_source_language(SourceLanguage::GLSL);
    // SPIR-V 1.5: 1.6 writes group sizes as LocalSizeId, which asks for a feature beyond the baseline (maintenance4).
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(OptimizationLevel::Zero);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(move |name, _, from, _| {
        if name == "shared.glsl" {
            return Ok(ResolvedInclude { resolved_name: name.into(), content: shared.into() });
        }
        let path = Path::new("glsl/inc").join(name);
        let content = fs::read_to_string(&path).map_err(|e| format!("{from} includes {}: {e}", path.display()))?;
        Ok(ResolvedInclude { resolved_name: path.display().to_string(), content })
    });
    options
}

fn main() {
    println!("cargo:rerun-if-changed=glsl");
    println!("cargo:rerun-if-changed=src/shared.rs");
    println!("cargo:rerun-if-changed=build.rs");
    let out_dir = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    let shared_source = fs::read_to_string("src/shared.rs").expect("src/shared.rs is readable");
    let (shared_glsl, shared_structs) = structs::translate(&shared_source);
    let compiler = Compiler::new().expect("shaderc starts");
    let options = options(&shared_glsl);
    let mut folders: BTreeMap<String, BTreeMap<String, Program>> = BTreeMap::new();
    for path in sources(Path::new("glsl")) {
        let extension = path.extension().unwrap().to_str().unwrap().to_string();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_string();
        let folder = path.parent().unwrap().file_name().unwrap().to_str().unwrap().to_string();
        let source = fs::read_to_string(&path).unwrap();
        let name = path.display().to_string();
        let compiled = compiler.compile_into_spirv(&source, kind(&extension).unwrap(), &name, "main", Some(&options));
        let compiled = compiled.unwrap_or_else(|e| panic!("{e}"));
        let spirv_file = format!("{folder}_{stem}_{extension}.spv");
        fs::write(out_dir.join(&spirv_file), compiled.as_binary_u8()).unwrap();
        let stage = Stage { extension, spirv_file, module: reflect::module(compiled.as_binary()) };
        let of_folder = folders.entry(folder.clone()).or_default();
        let program = of_folder.entry(stem.clone()).or_insert_with(|| Program { folder, stem, stages: Vec::new() });
        program.stages.push(stage);
    }
    let mut generated = String::new();
    for (folder, programs) in &mut folders {
        generated.push_str(&format!("/// Programs under `glsl/{folder}`.\npub mod {folder} {{\n"));
        for program in programs.values_mut() {
            program.stages.sort_by_key(|s| s.extension != "vert");
            generate::program(&mut generated, program, &shared_structs);
        }
        generated.push_str("}\n");
    }
    generated.push_str(&generate::list(&folders));
    fs::write(out_dir.join("shaders.rs"), generated).unwrap();
}
