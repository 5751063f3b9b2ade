//! What a device takes for the steps that techniques are made of: the numbers by which `auto` chooses.

use serde::{Deserialize, Serialize};

/// Nanoseconds unless said. Measured by `bench profile` and cached by device and driver version; else what was measured on a driver of
/// the kind, by the commands that docs/ACCURACY.md names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Where the numbers come from.
    pub source: String,
    /// One light is read as texels and shaded at one pixel of a full-screen loop (`bench ceiling`).
    pub texel_fetch: f64,
    /// The same, read from a uniform buffer.
    pub uniform_fetch: f64,
    /// The same, read from a storage buffer.
    pub storage_fetch: f64,
    /// Forward: one light is looked at for one pixel.
    pub test: f64,
    /// A fragment pass shades one listed light at one pixel.
    pub pair: f64,
    /// The same from a G-buffer.
    pub deferred_pair: f64,
    /// The same where a thread shades four pixels of a tile, which share what is read of the light.
    pub shared_pair: f64,
    /// A pixel's G-buffer is written and read, beyond shading the surface where it is drawn.
    pub gbuffer: f64,
    /// Depth bounds of a pixel, a thread a tile.
    pub bounds: f64,
    /// The same, a group of threads a tile; of tiles of 16 pixels, as the one before it. Larger tiles favour groups more.
    pub group_bounds: f64,
    /// One light is tested against one tile, counted and filled.
    pub cull: f64,
    /// A pixel's cluster is found.
    pub cluster: f64,
    /// A light's volume is set up.
    pub volume: f64,
    /// A pixel of a volume is tested.
    pub volume_pixel: f64,
    /// A pixel that a volume's light reaches is shaded and blended, beyond that. 0 where two loads gave no price of its own: shading is then in
    /// the price of a pixel.
    pub volume_pair: f64,
    /// Milliseconds: the steps of list making by themselves.
    pub lists_ms: f64,
    /// Milliseconds: the steps of cluster making by themselves.
    pub clusters_ms: f64,
    /// Of effects that are forced where nothing calls for them; `None` in profiles of versions that did not measure it.
    #[serde(default)]
    pub forced: Option<Forced>,
}

/// By how much a pixel takes longer where an effect is forced that nothing calls for, with input that changes nothing: what leaving it out saves. One
/// light has a shadow, four samples make a pixel. Nanoseconds, of `tiled-forward`; negative where the effect makes a pixel quicker.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Forced {
    /// Depth before shading.
    pub prepass: f64,
    /// Every surface is blended.
    pub transparency: f64,
    /// Every surface has a mask.
    pub alpha_mask: f64,
    /// Every surface has a normal map.
    pub normal_maps: f64,
    /// Every surface has a height map.
    pub parallax: f64,
    /// Every surface names a model.
    pub material_models: f64,
    /// Four samples a pixel.
    pub msaa: f64,
    /// Of one light; its maps are drawn once.
    pub shadows: f64,
}

impl Forced {
    fn numbers(&self) -> [f64; 8] {
        [
            self.prepass,
            self.transparency,
            self.alpha_mask,
            self.normal_maps,
            self.parallax,
            self.material_models,
            self.msaa,
            self.shadows,
        ]
    }

    /// Of an effect by name; `None` of those that are not forced.
    pub fn of(&self, effect: &str) -> Option<f64> {
        Some(match effect {
            "prepass" => self.prepass,
            "transparency" => self.transparency,
            "alpha_mask" => self.alpha_mask,
            "normal_maps" => self.normal_maps,
            "parallax" => self.parallax,
            "material_models" => self.material_models,
            "msaa" => self.msaa,
            "shadows" => self.shadows,
            _ => return None,
        })
    }
}

impl Profile {
    /// Mesa's llvmpipe 22.3.6 on two cores of an Intel Xeon (`bench profile`, the mean of two runs; the fetches, whose order is that of
    /// every machine met, by `bench ceiling` on an AMD EPYC; forced effects the mean of three runs on another machine of two cores).
    pub fn lavapipe() -> Self {
        Self {
            source: "defaults for lavapipe".into(),
            texel_fetch: 3.5,
            uniform_fetch: 4.5,
            storage_fetch: 29.0,
            test: 1.8,
            pair: 10.7,
            deferred_pair: 4.6,
            shared_pair: 3.2,
            gbuffer: 32.0,
            bounds: 11.0,
            group_bounds: 20.0,
            cull: 10.0,
            cluster: 46.0,
            volume: 11_000.0,
            volume_pixel: 9.5,
            volume_pair: 0.0,
            lists_ms: 0.7,
            clusters_ms: 2.3,
            forced: Some(Forced {
                prepass: -48.0,
                transparency: 36.0,
                alpha_mask: 18.0,
                normal_maps: 9.0,
                parallax: 7.0,
                material_models: 1.0,
                msaa: 208.0,
                shadows: 24.0,
            }),
        }
    }

    /// SwiftShader on the same two cores, likewise.
    pub fn swiftshader() -> Self {
        Self {
            source: "defaults for SwiftShader".into(),
            texel_fetch: 13.0,
            uniform_fetch: 13.0,
            storage_fetch: 13.0,
            test: 17.0,
            pair: 44.0,
            deferred_pair: 13.0,
            shared_pair: 6.0,
            gbuffer: 33.0,
            bounds: 17.0,
            group_bounds: 127.0,
            cull: 34.0,
            cluster: 63.0,
            volume: 27_500.0,
            volume_pixel: 48.0,
            volume_pair: 0.0,
            lists_ms: 0.5,
            clusters_ms: 1.0,
            forced: Some(Forced {
                prepass: -105.0,
                transparency: 82.0,
                alpha_mask: 33.0,
                normal_maps: 36.0,
                parallax: 0.0,
                material_models: 2.0,
                msaa: 720.0,
                shadows: 121.0,
            }),
        }
    }
}

impl Profile {
    /// Every number is finite and not negative.
    pub fn is_sound(&self) -> bool {
        let numbers = [
            self.texel_fetch,
            self.uniform_fetch,
            self.storage_fetch,
            self.test,
            self.pair,
            self.deferred_pair,
            self.shared_pair,
            self.gbuffer,
            self.bounds,
            self.group_bounds,
            self.cull,
            self.cluster,
            self.volume,
            self.volume_pixel,
            self.volume_pair,
            self.lists_ms,
            self.clusters_ms,
        ];
        let forced = self.forced.iter().flat_map(Forced::numbers);
        numbers.iter().all(|x| x.is_finite() && *x >= 0.0) && forced.into_iter().all(f64::is_finite)
    }
}

impl Default for Profile {
    /// Where nothing was measured: a driver of any other kind is ranked as lavapipe is.
    fn default() -> Self {
        Self { source: "defaults, measured on lavapipe".into(), ..Self::lavapipe() }
    }
}
