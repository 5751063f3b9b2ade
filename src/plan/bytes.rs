//! What a plan takes of a device's memory.

use super::{Accumulation, DEPTH_BYTES, Deferred, LightVolumes, Plan, RADIANCE_BYTES, Shadows};

impl Plan {
    /// Pixels of the picture.
    pub fn pixels(&self) -> u64 {
        u64::from(self.view.width) * u64::from(self.view.height)
    }

    /// Bytes of the attachments that a frame needs, shadow maps included.
    pub fn attachment_bytes(&self) -> u64 {
        self.attachment_bytes_of(self.samples) + self.shadows.as_ref().map_or(0, Shadows::image_bytes)
    }

    /// The same with so many samples a pixel.
    pub(super) fn attachment_bytes_of(&self, samples: u32) -> u64 {
        let halves = self.deferred.as_ref().is_some_and(|d| d.accumulation == Accumulation::F16);
        let colors = match (self.shows_surfaces(), halves) {
            (true, _) => 4 * RADIANCE_BYTES,
            (false, true) => RADIANCE_BYTES / 2,
            // Parts of a sum take turns with two images.
            (false, false) => RADIANCE_BYTES * u64::from(self.light_parts.count.min(2)),
        };
        let gbuffer = self.deferred.as_ref().filter(|_| !self.shows_surfaces());
        let stored = gbuffer.map_or(0, |d| d.gbuffer.texel_bytes());
        let samples = u64::from(samples);
        if samples == 1 {
            return self.pixels() * (colors + DEPTH_BYTES + stored);
        }
        // Samples and the picture that they make; a deferred one has samples of its own only where something is drawn over it.
        let sampled = match gbuffer {
            None => samples * colors,
            Some(_) if self.draws_over() => 2 * samples * colors,
            Some(_) => 0,
        };
        // Which pixels' samples differ.
        let edges = if gbuffer.is_some() { 4 } else { 0 };
        self.pixels() * (colors + sampled + edges + samples * (DEPTH_BYTES + stored))
    }

    /// Bytes of every buffer and texture that is filled before the first frame.
    pub fn static_bytes(&self) -> u64 {
        let volumes = self.deferred.as_ref().and_then(Deferred::volumes).map_or(0, LightVolumes::bytes);
        let markers = size_of_val(self.markers.as_slice()) as u64;
        let shadows = self.shadows.as_ref().map_or(0, Shadows::texel_bytes);
        self.geometry.bytes() + self.materials.bytes() + self.lights.bytes() + volumes + markers + shadows
    }
}
