//! A picture read back: f32 layers by name.

/// Layers of one frame, rows from the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Name and values, four a pixel or one a pixel.
    pub layers: Vec<(String, Vec<f32>)>,
}

impl Picture {
    /// A picture without layers.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, layers: Vec::new() }
    }

    /// Adds a layer of one or four values a pixel.
    pub fn add_layer(&mut self, name: &str, values: Vec<f32>) {
        self.layers.push((name.into(), values));
    }

    /// Values of a layer.
    pub fn layer(&self, name: &str) -> Option<&[f32]> {
        self.layers.iter().find(|l| l.0 == name).map(|l| l.1.as_slice())
    }

    /// A layer of four values a pixel.
    pub fn rgba(&self, name: &str) -> Option<&[[f32; 4]]> {
        let (pixels, rest) = self.layer(name)?.as_chunks();
        (rest.is_empty() && pixels.len() == self.width as usize * self.height as usize).then_some(pixels)
    }
}
