//! What each effect is called for by, what it costs and what turns it off: the one place that says so. The README shows this table, and a test compares
//! the two; the numbers of a picture are those of `Effect`.

/// One effect, in words for people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Statement {
    /// As [`super::Effect::name`].
    pub name: &'static str,
    /// What calls for it.
    pub called_by: &'static str,
    /// What it costs: passes, bytes, shader variants.
    pub costs: &'static str,
    /// What turns it off where something calls for it.
    pub off: &'static str,
}

/// Every effect, in the order in which plans list them.
pub const STATEMENTS: [Statement; 15] = [
    Statement {
        name: "prepass",
        called_by: "anything that is drawn",
        costs: "a pass over the geometry; 4 bytes a pixel and sample; a pipeline for opaque surfaces, one for each kind of mask",
        off: "`--prepass off`, `--forbid prepass`",
    },
    Statement {
        name: "lights",
        called_by: "a light that reaches anything; without one the default light",
        costs: "32 bytes a light, 64 where there are spot lights; shaders for the kinds of lights that there are",
        off: "ranges and cut-offs that leave none",
    },
    Statement {
        name: "gbuffer",
        called_by: "`--technique deferred`, `tiled-deferred`, `clustered-deferred`",
        costs: "a pass over the geometry; 12 to 80 bytes a pixel and sample; an image for emission only where something emits",
        off: "another technique",
    },
    Statement {
        name: "light_volumes",
        called_by: "`--technique deferred` and lights with a place",
        costs: "a pass that blends; 20 bytes a light and a mesh; two pipelines",
        off: "`--deferred-lights fullscreen`, `fullscreen-branch`",
    },
    Statement {
        name: "depth_bounds",
        called_by: "light lists and a pre-pass",
        costs: "a pass; 16 bytes a tile",
        off: "`--depth-bounds off`, `--forbid depth_bounds`",
    },
    Statement {
        name: "light_lists",
        called_by: "a technique with lists, and a light that ends somewhere",
        costs: "passes that bin, count and fill; 4 bytes a pair of tile and light; 48 bytes a light, 80 with spot lights",
        off: "another technique, `--assign tree`",
    },
    Statement {
        name: "clusters",
        called_by: "`--technique clustered-forward`, `clustered-deferred`, likewise",
        costs: "passes that key, compact, count and fill; 4 bytes a pair of cluster and light",
        off: "another technique",
    },
    Statement {
        name: "normal_maps",
        called_by: "a material with a normal map",
        costs: "16 bytes a vertex for tangents; a pipeline for each set of maps that occurs",
        off: "`--forbid normal_maps`",
    },
    Statement {
        name: "parallax",
        called_by: "`extras.lampyris.heightTexture` of a material",
        costs: "8 reads of the height map in every pass that reads the surface; tangents and pipelines as for normal maps",
        off: "`--forbid parallax`",
    },
    Statement {
        name: "material_models",
        called_by: "`extras.lampyris.model` of a material",
        costs: "a pipeline a model; in deferred techniques 4 bytes a pixel and a branch",
        off: "`--forbid material_models`",
    },
    Statement {
        name: "alpha_mask",
        called_by: "a material with `alphaMode: MASK`",
        costs: "a read of alpha in every pass over the surface, with several samples one a sample; pipelines that can discard",
        off: "`--forbid alpha_mask`",
    },
    Statement {
        name: "msaa",
        called_by: "`--msaa 2|4|8`; a number that the device lacks is replaced by the nearest, with `--strict` refused",
        costs: "images of so many samples. Forward techniques shade once a triangle and pixel, at a place within the triangle; deferred ones find pixels whose samples differ and light these sample by sample",
        off: "`--msaa 1`, `--forbid msaa`",
    },
    Statement {
        name: "transparency",
        called_by: "a material with `alphaMode: BLEND` on a surface",
        costs: "a pass at the end, back to front by object or by triangle (`--transparent-sort`); lists of lights of their own (`--transparent-bounds own`), the lists of opaque surfaces (`merged`) or lists that know nothing of depths (`none`); 4 bytes a pixel and sample for their nearest depths where lists ask for them, where 32-bit floats are not blended a layer; a pipeline for each set of maps",
        off: "`--forbid transparency`",
    },
    Statement {
        name: "shadows",
        called_by: "`extras.lampyris.shadow` of a light, or `--shadows N`: the N lights that matter most in view (mean illuminance within their range times the share of the picture that it covers); light that reaches something that is seen",
        costs: "a pass, run once while nothing moves (`--shadow-update frame`: in every frame); maps of depth in one image, 4 bytes a texel, `--shadow-size` columns each: one for a spot light of at most 60 degrees to a side, up to six (the sides of a cube that see something of the view) for others with a place, up to four (cascades) for a directional one; `(filter + 1)^2` reads a pixel and light (`--shadow-filter`); a variant of every shader that lights",
        off: "`--shadows 0`, `--forbid shadows`",
    },
    Statement {
        name: "radiosity",
        called_by: "`--gi radiosity`, where patches reflect more than the tolerance or emit",
        costs: "a pass for the light of patches and one a gather, run once while nothing moves; the matrix (half a byte an element and less), about 600 bytes a patch and its points, 4 bytes a word of the grid; shadows of all lights; a variant of every shader that lights, which mixes the patches about each pixel",
        off: "`--gi off`, `--forbid radiosity`",
    },
];
