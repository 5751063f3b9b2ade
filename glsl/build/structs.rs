//! Turns `src/shared.rs` into GLSL, so that a struct or constant that both sides see is declared once.

use std::fmt::Write;

use syn::{Expr, Fields, Item, Lit, Type};

/// Name and fields of one shared struct, in order.
pub struct Shared {
    pub name: String,
    pub fields: Vec<String>,
}

fn number(expr: &Expr) -> Option<String> {
    match expr {
        Expr::Lit(lit) => match &lit.lit {
            Lit::Int(int) => Some(int.base10_digits().to_string()),
            Lit::Float(float) => Some(float.base10_digits().to_string()),
            _ => None,
        },
        _ => None,
    }
}

fn glsl_type(ty: &Type) -> Option<&'static str> {
    let Type::Path(path) = ty else { return None };
    Some(match path.path.segments.last()?.ident.to_string().as_str() {
        "u32" => "uint",
        "i32" => "int",
        "f32" => "float",
        "Vec2" => "vec2",
        "Vec3" => "vec3",
        "Vec4" => "vec4",
        "UVec2" => "uvec2",
        "UVec3" => "uvec3",
        "UVec4" => "uvec4",
        "Mat3" => "mat3",
        "Mat4" => "mat4",
        _ => return None,
    })
}

/// GLSL text of all public structs and `u32` or `f32` constants of the Rust source, and the structs' fields.
pub fn translate(source: &str) -> (String, Vec<Shared>) {
    let file = syn::parse_file(source).expect("src/shared.rs is Rust");
    let mut glsl = String::from("// Made from src/shared.rs by build.rs.\n");
    let mut structs = Vec::new();
    for item in &file.items {
        match item {
            Item::Const(constant) => {
                let kind = glsl_type(&constant.ty).expect("shared constants are u32, i32 or f32");
                let value = number(&constant.expr).expect("shared constants are literals");
                let suffix = if kind == "uint" { "u" } else { "" };
                writeln!(glsl, "const {kind} {} = {value}{suffix};", constant.ident).unwrap();
            }
            Item::Struct(declared) => {
                let Fields::Named(named) = &declared.fields else { continue };
                let mut fields = Vec::new();
                writeln!(glsl, "struct {} {{", declared.ident).unwrap();
                for field in &named.named {
                    let name = field.ident.as_ref().unwrap().to_string();
                    let kind =
                        glsl_type(&field.ty).unwrap_or_else(|| panic!("{}.{name}: no GLSL type", declared.ident));
                    writeln!(glsl, "    {kind} {name};").unwrap();
                    fields.push(name);
                }
                glsl.push_str("};\n");
                structs.push(Shared { name: declared.ident.to_string(), fields });
            }
            _ => {}
        }
    }
    (glsl, structs)
}
