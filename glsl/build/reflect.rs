//! Reads from SPIR-V what the Rust side has to agree with: bindings, block layouts, specialization constants, group size.

use std::collections::{BTreeMap, HashMap};

/// How a binding is used, as far as the shader says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Uniform,
    StorageRead,
    StorageWrite,
    StorageReadWrite,
    UniformTexel,
    Sampled,
    /// An image of several samples, of layers, or of depths that are compared: bound where an effect runs.
    SampledIf,
    ImageRead,
    ImageWrite,
    ImageReadWrite,
}

#[derive(Debug, Clone)]
pub struct Binding {
    pub name: String,
    pub set: u32,
    pub binding: u32,
    pub kind: Kind,
}

/// A struct's members with their byte offsets.
#[derive(Debug, Clone)]
pub struct Block {
    pub name: String,
    pub members: Vec<(String, u32)>,
    /// Bytes from one element to the next where the struct is an array's element.
    pub stride: Option<u32>,
}

#[derive(Debug, Clone)]
pub struct SpecConstant {
    pub name: String,
    pub id: u32,
    pub default: u32,
    pub is_bool: bool,
    pub is_float: bool,
}

#[derive(Debug, Default)]
pub struct Module {
    pub bindings: Vec<Binding>,
    pub blocks: Vec<Block>,
    pub spec_constants: Vec<SpecConstant>,
    /// Struct name of the push constant block.
    pub push: Option<String>,
    pub local_size: [u32; 3],
    /// Locations of the stage's inputs (vertex attributes for a vertex shader).
    pub inputs: Vec<u32>,
    pub output_count: u32,
}

#[derive(Default)]
struct Decorations {
    set: Option<u32>,
    binding: Option<u32>,
    spec_id: Option<u32>,
    location: Option<u32>,
    array_stride: Option<u32>,
    non_writable: bool,
    non_readable: bool,
    builtin: bool,
}

enum Type {
    Struct(Vec<u32>),
    Array(u32),
    Pointer(u32),
    Image { dim: u32, special: bool, sampled: u32 },
    SampledImage(u32),
}

#[derive(Default)]
struct Tables {
    names: HashMap<u32, String>,
    member_names: HashMap<(u32, u32), String>,
    decorations: HashMap<u32, Decorations>,
    member_offsets: HashMap<(u32, u32), u32>,
    member_non_writable: HashMap<u32, u32>,
    member_non_readable: HashMap<u32, u32>,
    types: HashMap<u32, Type>,
    variables: Vec<(u32, u32, u32)>,
    specs: Vec<(u32, u32, u32)>,
    bools: Vec<u32>,
    floats: Vec<u32>,
    local_size: [u32; 3],
}

fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).take_while(|&b| b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn scan(words: &[u32]) -> Tables {
    let mut t = Tables { local_size: [1; 3], ..Tables::default() };
    let mut at = 5;
    while at < words.len() {
        let (count, op) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        let w = &words[at + 1..at + count];
        match op {
            5 => drop(t.names.insert(w[0], text(&w[1..]))),
            6 => drop(t.member_names.insert((w[0], w[1]), text(&w[2..]))),
            16 if w[1] == 17 => t.local_size = [w[2], w[3], w[4]],
            20 => t.bools.push(w[0]),
            22 => t.floats.push(w[0]),
            25 => {
                drop(t.types.insert(
                    w[0],
                    Type::Image { dim: w[2], special: w[3] == 1 || w[4] == 1 || w[5] == 1, sampled: w[6] },
                ))
            }
            27 => drop(t.types.insert(w[0], Type::SampledImage(w[1]))),
            28 | 29 => drop(t.types.insert(w[0], Type::Array(w[1]))),
            30 => drop(t.types.insert(w[0], Type::Struct(w[1..].to_vec()))),
            32 => drop(t.types.insert(w[0], Type::Pointer(w[2]))),
            48 => t.specs.push((w[1], w[0], 1)),
            49 => t.specs.push((w[1], w[0], 0)),
            50 => t.specs.push((w[1], w[0], w[2])),
            59 => t.variables.push((w[1], w[0], w[2])),
            71 => {
                let d = t.decorations.entry(w[0]).or_default();
                match w[1] {
                    1 => d.spec_id = Some(w[2]),
                    6 => d.array_stride = Some(w[2]),
                    11 => d.builtin = true,
                    24 => d.non_writable = true,
                    25 => d.non_readable = true,
                    30 => d.location = Some(w[2]),
                    33 => d.binding = Some(w[2]),
                    34 => d.set = Some(w[2]),
                    _ => {}
                }
            }
            72 => match w[2] {
                24 => *t.member_non_writable.entry(w[0]).or_default() += 1,
                25 => *t.member_non_readable.entry(w[0]).or_default() += 1,
                35 => drop(t.member_offsets.insert((w[0], w[1]), w[3])),
                _ => {}
            },
            _ => {}
        }
        at += count;
    }
    t
}

impl Tables {
    fn pointee(&self, pointer: u32) -> u32 {
        match self.types.get(&pointer) {
            Some(Type::Pointer(inner)) => *inner,
            _ => pointer,
        }
    }

    fn kind(&self, variable: u32, pointer: u32, storage_class: u32) -> Option<Kind> {
        let inner = self.pointee(pointer);
        if let Some(Type::Array(_)) = self.types.get(&inner) {
            panic!("arrays of descriptors are not reflected");
        }
        let on_variable = self.decorations.get(&variable);
        let variable_flags = on_variable.map_or((false, false), |d| (d.non_writable, d.non_readable));
        Some(match (storage_class, self.types.get(&inner)?) {
            (2, Type::Struct(_)) => Kind::Uniform,
            (12, Type::Struct(members)) => {
                let all = members.len() as u32;
                let read_only = variable_flags.0 || self.member_non_writable.get(&inner) == Some(&all);
                let write_only = variable_flags.1 || self.member_non_readable.get(&inner) == Some(&all);
                match (read_only, write_only) {
                    (true, _) => Kind::StorageRead,
                    (_, true) => Kind::StorageWrite,
                    _ => Kind::StorageReadWrite,
                }
            }
            (0, Type::SampledImage(image)) => match self.types.get(image)? {
                Type::Image { dim: 5, .. } => Kind::UniformTexel,
                Type::Image { special: true, .. } => Kind::SampledIf,
                _ => Kind::Sampled,
            },
            (0, Type::Image { dim: 5, sampled: 1, .. }) => Kind::UniformTexel,
            (0, Type::Image { sampled: 2, .. }) => match variable_flags {
                (true, _) => Kind::ImageRead,
                (_, true) => Kind::ImageWrite,
                _ => Kind::ImageReadWrite,
            },
            (0, Type::Image { .. }) => Kind::Sampled,
            _ => return None,
        })
    }

    /// A push constant block holds one shared struct; its name is wanted, not the block's.
    fn push_struct(&self, pointer: u32) -> Option<String> {
        match self.types.get(&self.pointee(pointer)) {
            Some(Type::Struct(members)) if members.len() == 1 => self.names.get(&members[0]).cloned(),
            _ => None,
        }
    }

    fn blocks(&self) -> Vec<Block> {
        let strides: HashMap<u32, u32> = self
            .types
            .iter()
            .filter_map(|(id, ty)| match ty {
                Type::Array(element) => Some((*element, self.decorations.get(id)?.array_stride?)),
                _ => None,
            })
            .collect();
        let mut blocks = BTreeMap::new();
        for (id, ty) in &self.types {
            let (Type::Struct(members), Some(name)) = (ty, self.names.get(id)) else { continue };
            let found: Vec<_> = (0..members.len() as u32)
                .filter_map(|m| Some((self.member_names.get(&(*id, m))?.clone(), *self.member_offsets.get(&(*id, m))?)))
                .collect();
            if found.len() == members.len() && !found.is_empty() {
                let stride = strides.get(id).copied();
                blocks.insert(name.clone(), Block { name: name.clone(), members: found, stride });
            }
        }
        blocks.into_values().collect()
    }
}

/// Reflects one SPIR-V module.
pub fn module(words: &[u32]) -> Module {
    let t = scan(words);
    let mut module = Module { local_size: t.local_size, blocks: t.blocks(), ..Module::default() };
    for &(id, pointer, class) in &t.variables {
        let decorations = t.decorations.get(&id);
        let location = decorations.and_then(|d| d.location);
        match (class, location) {
            (1, Some(location)) if !decorations.is_some_and(|d| d.builtin) => module.inputs.push(location),
            (3, Some(_)) => module.output_count += 1,
            (9, _) => module.push = t.push_struct(pointer),
            _ => {}
        }
        let Some((set, binding)) = decorations.and_then(|d| d.set.zip(d.binding)) else { continue };
        let Some(kind) = t.kind(id, pointer, class) else { panic!("unknown kind of binding {set}.{binding}") };
        let name = t.names.get(&id).filter(|n| !n.is_empty()).cloned();
        let name = name.unwrap_or_else(|| panic!("binding {set}.{binding} needs an instance name"));
        module.bindings.push(Binding { name, set, binding, kind });
    }
    for &(id, ty, default) in &t.specs {
        let Some(spec_id) = t.decorations.get(&id).and_then(|d| d.spec_id) else { continue };
        module.spec_constants.push(SpecConstant {
            // Only local_size_x_id declares one without a name.
            name: t.names.get(&id).filter(|name| !name.is_empty()).cloned().unwrap_or_else(|| "GROUP_SIZE".into()),
            id: spec_id,
            default,
            is_bool: t.bools.contains(&ty),
            is_float: t.floats.contains(&ty),
        });
    }
    module.bindings.sort_by_key(|b| (b.set, b.binding));
    module.spec_constants.sort_by_key(|s| s.id);
    module.inputs.sort_unstable();
    module
}
