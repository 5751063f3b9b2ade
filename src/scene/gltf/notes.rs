//! What was dropped, replaced or is not supported, each said once with its count.

use std::collections::BTreeMap;

/// A kind of warning; the order is the order in which they are said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Note {
    Animations,
    Skins,
    MorphTargets,
    GpuInstancing,
    Draco,
    Points,
    Lines,
    WithoutPositions,
    ZeroArea,
    IncompleteTriangles,
    NormalsReplaced,
    TangentsReplaced,
    TangentsSimplified,
    NormalMapWithoutUvs,
    TextureWithoutUvs,
    OtherUvSet,
    OtherImageFormat,
    TextureWithoutImage,
    FlatNode,
    FlatCamera,
    MirroredCamera,
    UnknownExtras,
}

/// Counts of notes.
#[derive(Default)]
pub(super) struct Notes {
    counts: BTreeMap<Note, u64>,
    sentences: Vec<String>,
}

impl Notes {
    /// Counts one.
    pub(super) fn add(&mut self, note: Note) {
        self.add_many(note, 1);
    }

    /// Counts `count`, which may be 0.
    pub(super) fn add_many(&mut self, note: Note, count: u64) {
        if count > 0 {
            *self.counts.entry(note).or_default() += count;
        }
    }

    /// A warning that is said first and has no count.
    pub(super) fn say(&mut self, sentence: String) {
        self.sentences.push(sentence);
    }

    /// All warnings.
    pub(super) fn into_sentences(mut self) -> Vec<String> {
        self.sentences.extend(self.counts.iter().map(|(note, count)| note.sentence(*count)));
        self.sentences
    }
}

/// Singular, plural, and what became of them; in the order of [`Note`].
const WORDS: [(Note, [&str; 3]); 22] = [
    (Note::Animations, ["animation", "animations", "not played, the scene is drawn at rest"]),
    (Note::Skins, ["skinned node", "skinned nodes", "drawn in the pose of the file's vertices"]),
    (Note::MorphTargets, ["primitive with morph targets", "primitives with morph targets", "drawn without them"]),
    (
        Note::GpuInstancing,
        ["node with EXT_mesh_gpu_instancing", "nodes with EXT_mesh_gpu_instancing", "drawn once each"],
    ),
    (
        Note::Draco,
        ["primitive compressed with Draco", "primitives compressed with Draco", "drawn from the uncompressed fallback"],
    ),
    (Note::Points, ["primitive of points", "primitives of points", "not supported and not drawn"]),
    (Note::Lines, ["primitive of lines", "primitives of lines", "not supported and not drawn"]),
    (Note::WithoutPositions, ["primitive without positions", "primitives without positions", "not drawn"]),
    (Note::ZeroArea, ["triangle of zero area", "triangles of zero area", "dropped"]),
    (
        Note::IncompleteTriangles,
        ["primitive with an incomplete last triangle", "primitives with an incomplete last triangle", "cut"],
    ),
    (
        Note::NormalsReplaced,
        [
            "normal of zero length or not a number",
            "normals of zero length or not numbers",
            "replaced by the geometric normal",
        ],
    ),
    (
        Note::TangentsReplaced,
        [
            "tangent of zero length, along the normal or not a number",
            "tangents of zero length, along the normal or not numbers",
            "replaced by some direction across the normal",
        ],
    ),
    (
        Note::TangentsSimplified,
        [
            "primitive too large or with too many triangles at one point for MikkTSpace",
            "primitives too large or with too many triangles at one point for MikkTSpace",
            "tangents are plain averages of the texture's direction",
        ],
    ),
    (
        Note::NormalMapWithoutUvs,
        [
            "primitive without the texture coordinates of its normal or height map",
            "primitives without the texture coordinates of their normal or height maps",
            "drawn without either map",
        ],
    ),
    (
        Note::TextureWithoutUvs,
        [
            "textured primitive without texture coordinates",
            "textured primitives without texture coordinates",
            "sampled at (0, 0)",
        ],
    ),
    (
        Note::OtherUvSet,
        [
            "texture with a coordinate set other than 0 and 1",
            "textures with a coordinate set other than 0 and 1",
            "set 0 is used",
        ],
    ),
    (
        Note::OtherImageFormat,
        [
            "texture in WebP, KTX2 or another format than PNG and JPEG",
            "textures in WebP, KTX2 or other formats than PNG and JPEG",
            "ignored",
        ],
    ),
    (Note::TextureWithoutImage, ["texture without an image", "textures without an image", "ignored"]),
    (
        Note::FlatNode,
        [
            "mesh instance with a scale of zero or a matrix without an inverse",
            "mesh instances with a scale of zero or a matrix without an inverse",
            "dropped",
        ],
    ),
    (
        Note::FlatCamera,
        [
            "camera with a scale of zero or a matrix without an inverse",
            "cameras with a scale of zero or a matrix without an inverse",
            "dropped",
        ],
    ),
    (Note::MirroredCamera, ["camera in a mirrored node", "cameras in mirrored nodes", "the mirroring is taken out"]),
    (
        Note::UnknownExtras,
        ["member of extras.lampyris that is not known", "members of extras.lampyris that are not known", "ignored"],
    ),
];

impl Note {
    fn sentence(self, n: u64) -> String {
        let (_, [one, many, what]) = WORDS[self as usize];
        format!("{n} {}: {what}", if n == 1 { one } else { many })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_said_once() {
        let mut notes = Notes::default();
        notes.add(Note::FlatCamera);
        notes.add_many(Note::Lines, 2);
        notes.add(Note::Lines);
        notes.add_many(Note::Points, 0);
        notes.say("first".into());
        let sentences = notes.into_sentences();
        assert_eq!(sentences.len(), 3);
        assert_eq!(sentences[0], "first");
        assert_eq!(sentences[1], "3 primitives of lines: not supported and not drawn");
        assert_eq!(sentences[2], Note::FlatCamera.sentence(1));
    }

    #[test]
    fn words_stand_in_the_order_of_notes() {
        for (at, (note, _)) in WORDS.iter().enumerate() {
            assert_eq!(*note as usize, at, "{note:?}");
        }
    }
}
