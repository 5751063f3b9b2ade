//! Writes the Rust module of each shader program: SPIR-V, typed bindings, specialization constants, group size, and the
//! proofs that shared structs lie at the same offsets on both sides.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::reflect::{Kind, Module, SpecConstant};
use crate::structs::Shared;

/// One stage of a program.
pub struct Stage {
    /// `vert`, `frag` or `comp`.
    pub extension: String,
    pub spirv_file: String,
    pub module: Module,
}

/// All stages that share a stem, e.g. `shade/forward`.
pub struct Program {
    pub folder: String,
    pub stem: String,
    pub stages: Vec<Stage>,
}

fn stage_flag(extension: &str) -> &'static str {
    match extension {
        "vert" => "VERTEX",
        "frag" => "FRAGMENT",
        _ => "COMPUTE",
    }
}

fn access_type(stages: &[&str], kind: Kind) -> String {
    let stage = match stages {
        ["comp"] => "Compute",
        ["vert"] => "Vertex",
        ["frag"] => "Fragment",
        _ => "Graphics",
    };
    let kind = match kind {
        Kind::Uniform => "Uniform",
        Kind::StorageRead => "StorageRead",
        Kind::StorageWrite => "StorageWrite",
        Kind::StorageReadWrite => "StorageReadWrite",
        Kind::UniformTexel => "Texel",
        Kind::Sampled | Kind::SampledIf => "Sampled",
        Kind::ImageRead => "ImageRead",
        Kind::ImageWrite => "ImageWrite",
        Kind::ImageReadWrite => "ImageReadWrite",
    };
    format!("{stage}{kind}")
}

/// Bindings over all stages: (set, binding, name, kind, stages).
fn merged_bindings(program: &Program) -> Vec<(u32, u32, String, Kind, Vec<&str>)> {
    let mut merged: Vec<(u32, u32, String, Kind, Vec<&str>)> = Vec::new();
    for stage in &program.stages {
        for b in &stage.module.bindings {
            match merged.iter_mut().find(|m| (m.0, m.1) == (b.set, b.binding)) {
                Some(m) => {
                    assert!(
                        m.2 == b.name && m.3 == b.kind,
                        "{}: binding {}.{} differs",
                        program.stem,
                        b.set,
                        b.binding
                    );
                    m.4.push(&stage.extension);
                }
                None => merged.push((b.set, b.binding, b.name.clone(), b.kind, vec![&stage.extension])),
            }
        }
    }
    merged.sort_by_key(|m| (m.0, m.1));
    merged
}

fn merged_specs(program: &Program) -> Vec<SpecConstant> {
    let mut specs: Vec<SpecConstant> = Vec::new();
    for spec in program.stages.iter().flat_map(|s| &s.module.spec_constants) {
        match specs.iter().find(|s| s.id == spec.id) {
            Some(known) => assert_eq!(known.name, spec.name, "{}: constant id {} has two names", program.stem, spec.id),
            None => specs.push(spec.clone()),
        }
    }
    specs.sort_by_key(|s| s.id);
    specs
}

fn layout_proofs(out: &mut String, program: &Program, shared: &[Shared]) {
    for stage in &program.stages {
        for block in &stage.module.blocks {
            let Some(known) = shared.iter().find(|s| s.name == block.name) else { continue };
            let rust = format!("crate::shared::{}", known.name);
            writeln!(out, "    const _: () = {{").unwrap();
            for (member, offset) in &block.members {
                writeln!(out, "        assert!(std::mem::offset_of!({rust}, {member}) == {offset});").unwrap();
            }
            assert_eq!(block.members.len(), known.fields.len(), "{}: member count", block.name);
            if let Some(stride) = block.stride {
                writeln!(out, "        assert!(std::mem::size_of::<{rust}>() == {stride});").unwrap();
            }
            writeln!(out, "    }};").unwrap();
        }
    }
}

fn spec_struct(out: &mut String, specs: &[SpecConstant]) {
    if specs.is_empty() {
        return;
    }
    writeln!(out, "    /// Specialization constants.\n    #[derive(Debug, Clone, Copy, PartialEq)]").unwrap();
    writeln!(out, "    #[allow(non_snake_case)]\n    pub struct Spec {{").unwrap();
    let kind = |s: &SpecConstant| {
        if s.is_bool {
            "bool"
        } else if s.is_float {
            "f32"
        } else {
            "u32"
        }
    };
    for s in specs {
        writeln!(out, "        /// Constant id {}.\n        pub {}: {},", s.id, s.name, kind(s)).unwrap();
    }
    writeln!(out, "    }}\n    impl Default for Spec {{\n        fn default() -> Self {{\n            Self {{")
        .unwrap();
    for s in specs {
        let value = match kind(s) {
            "bool" => (s.default != 0).to_string(),
            "f32" => format!("f32::from_bits({})", s.default),
            _ => s.default.to_string(),
        };
        writeln!(out, "                {}: {value},", s.name).unwrap();
    }
    writeln!(out, "            }}\n        }}\n    }}\n    impl Spec {{").unwrap();
    writeln!(out, "        /// (id, bits) of every constant.\n        pub fn values(&self) -> Vec<(u32, u32)> {{")
        .unwrap();
    let bits = |s: &SpecConstant| match kind(s) {
        "bool" => format!("({}, u32::from(self.{}))", s.id, s.name),
        "f32" => format!("({}, self.{}.to_bits())", s.id, s.name),
        _ => format!("({}, self.{})", s.id, s.name),
    };
    let all: Vec<_> = specs.iter().map(bits).collect();
    writeln!(out, "            vec![{}]\n        }}\n    }}", all.join(", ")).unwrap();
}

/// Bound where an effect runs, and in no set layout elsewhere.
fn is_optional(name: &str, kind: Kind) -> bool {
    kind == Kind::SampledIf || name.starts_with("shadow_") || name.starts_with("bounced_")
}

fn bindings_struct(out: &mut String, program: &Program) {
    let merged = merged_bindings(program);
    let mut sets: Vec<u32> = merged.iter().map(|m| m.0).collect();
    sets.dedup();
    for set in sets {
        let name = if set == 0 { "Bindings".to_string() } else { format!("Bindings{set}") };
        let of_set: Vec<_> = merged.iter().filter(|m| m.0 == set).collect();
        writeln!(out, "    /// Descriptor set {set}: a field a binding, named as in the shader.").unwrap();
        writeln!(out, "    #[derive(Debug, Clone, Copy)]\n    pub struct {name} {{").unwrap();
        for m in &of_set {
            let access = access_type(&m.4, m.3);
            let field =
                if is_optional(&m.2, m.3) { format!("Option<access::{access}>") } else { format!("access::{access}") };
            writeln!(out, "        /// Binding {}.\n        pub {}: {field},", m.1, m.2).unwrap();
        }
        writeln!(out, "    }}\n    impl {name} {{").unwrap();
        writeln!(out, "        /// Every binding with its declared access.").unwrap();
        let optional = of_set.iter().any(|m| is_optional(&m.2, m.3));
        writeln!(out, "        pub fn list(&self) -> Vec<Binding> {{").unwrap();
        writeln!(out, "            {}", if optional { "let mut list = vec![" } else { "vec![" }).unwrap();
        for m in of_set.iter().filter(|m| !is_optional(&m.2, m.3)) {
            writeln!(out, "                self.{}.bound(\"{}\", {set}, {}),", m.2, m.2, m.1).unwrap();
        }
        writeln!(out, "            ]{}", if optional { ";" } else { "" }).unwrap();
        for m in of_set.iter().filter(|m| is_optional(&m.2, m.3)) {
            writeln!(out, "            list.extend(self.{}.map(|b| b.bound(\"{}\", {set}, {})));", m.2, m.2, m.1)
                .unwrap();
        }
        if optional {
            writeln!(out, "            list").unwrap();
        }
        writeln!(out, "        }}\n    }}").unwrap();
    }
}

/// The module of one program.
pub fn program(out: &mut String, program: &Program, shared: &[Shared]) {
    let name = format!("{}/{}", program.folder, program.stem);
    writeln!(out, "/// Program `{name}`.\npub mod {} {{", program.stem).unwrap();
    writeln!(out, "    #[allow(unused_imports)]\n    use crate::graph::{{access, program::{{Program, Stage, Slot, SlotKind}}, Binding}};").unwrap();
    writeln!(out, "    /// Stages, slots and group size.\n    pub static PROGRAM: Program = Program {{").unwrap();
    writeln!(out, "        name: \"{name}\",\n        stages: &[").unwrap();
    for stage in &program.stages {
        writeln!(
            out,
            "            Stage {{ stage: ash::vk::ShaderStageFlags::{}, spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{}\")) }},",
            stage_flag(&stage.extension),
            stage.spirv_file
        )
        .unwrap();
    }
    writeln!(out, "        ],\n        slots: &[").unwrap();
    for (set, binding, slot, kind, stages) in merged_bindings(program) {
        let flags: Vec<_> =
            stages.iter().map(|s| format!("ash::vk::ShaderStageFlags::{}.as_raw()", stage_flag(s))).collect();
        writeln!(
            out,
            "            Slot {{ name: \"{slot}\", set: {set}, binding: {binding}, kind: SlotKind::{}, stages: ash::vk::ShaderStageFlags::from_raw({}) }},",
            if kind == Kind::SampledIf { "Sampled".to_string() } else { format!("{kind:?}") },
            flags.join(" | ")
        )
        .unwrap();
    }
    let local = program.stages.iter().find(|s| s.extension == "comp").map_or([1; 3], |s| s.module.local_size);
    let inputs = program.stages.iter().find(|s| s.extension == "vert").map_or(&[][..], |s| &s.module.inputs);
    let push = program.stages.iter().find_map(|s| s.module.push.clone());
    let push_bytes =
        push.as_ref().map_or("0".to_string(), |p| format!("std::mem::size_of::<crate::shared::{p}>() as u32"));
    writeln!(out, "        ],\n        local_size: {local:?},\n        inputs: &{inputs:?},\n        push_bytes: {push_bytes},\n    }};").unwrap();
    bindings_struct(out, program);
    spec_struct(out, &merged_specs(program));
    layout_proofs(out, program, shared);
    writeln!(out, "}}").unwrap();
}

/// A list of every program, by folder and stem.
pub fn list(folders: &BTreeMap<String, BTreeMap<String, Program>>) -> String {
    let paths = folders.iter().flat_map(|(folder, programs)| programs.keys().map(move |stem| (folder, stem)));
    let entries: String = paths.map(|(folder, stem)| format!("    &{folder}::{stem}::PROGRAM,\n")).collect();
    format!("/// Every program.\npub static ALL: &[&crate::graph::program::Program] = &[\n{entries}];\n")
}
