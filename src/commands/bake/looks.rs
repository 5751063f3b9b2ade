//! Who looks what stands between patches.

use std::time::Instant;

use crate::cli::BakeOnArg;
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::radiosity::Patches;
use crate::radiosity::factors::RawRows;
use crate::radiosity::sight::Sight;
use crate::reference::render::Reference;
use crate::renderer::Renderer;
use crate::renderer::sight::DeviceSight;

/// Fewer patches are done before a device is open.
const FEWEST: usize = 500;
/// Rows that both try, from the middle.
const TRIED: usize = 4;

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Looks {
    pub on: BakeOnArg,
    pub options: Options,
}

impl Looks {
    /// Whatever is quicker.
    pub fn auto() -> Self {
        Self { on: BakeOnArg::Auto, options: Options { validate: false, driver: None } }
    }

    /// The device, where one is asked for or may be worth it.
    ///
    /// # Errors
    /// None, where one is asked for.
    pub fn renderer(&self, patches: usize) -> Result<Option<Renderer>> {
        match self.on {
            BakeOnArg::Cpu => Ok(None),
            BakeOnArg::Device => Renderer::new(&self.options).map(Some),
            BakeOnArg::Auto if patches < FEWEST && self.options.driver.is_none() => Ok(None),
            BakeOnArg::Auto => Ok(Renderer::new(&self.options).ok()),
        }
    }

    /// The device with the scene's triangles, where it is asked for or was quicker on a few rows; and what was measured.
    ///
    /// # Errors
    /// A device that is asked for and cannot.
    pub fn device<'a>(
        &self,
        renderer: Option<&'a Renderer>,
        reference: &'a Reference<'a>,
        (patches, seed): (&Patches, u64),
    ) -> Result<(Option<DeviceSight<'a>>, String)> {
        let Some(renderer) = renderer else { return Ok((None, "CPU".into())) };
        let device = match renderer.sight(reference) {
            Err(error) if self.on == BakeOnArg::Device => return Err(error),
            Err(error) => return Ok((None, format!("CPU: {error}"))),
            Ok(device) => device,
        };
        let name = &renderer.device().facts.name;
        if self.on == BakeOnArg::Device {
            return Ok((Some(device), name.clone()));
        }
        let count = patches.list.len();
        let first = count.saturating_sub(TRIED) / 2;
        let time = |sight: &dyn Sight| -> Result<f64> {
            let start = Instant::now();
            RawRows::new(patches, sight, seed, first..(first + TRIED).min(count), &|| {})?;
            Ok(start.elapsed().as_secs_f64() * 1e3)
        };
        // The first batch of a driver on the CPU compiles.
        let on_device = time(&device).and_then(|_| time(&device))?;
        let on_cpu = time(reference)?;
        let measured = format!("{TRIED} rows in {on_device:.0} ms on {name}, in {on_cpu:.0} ms on the CPU");
        Ok(if on_device < on_cpu {
            (Some(device), format!("{name}: {measured}"))
        } else {
            (None, format!("CPU: {measured}"))
        })
    }
}

/// What a device has done, or what is wrong with it.
///
/// # Errors
/// Messages of the validation layer, and what the checker found.
pub fn judged(device: &DeviceSight, renderer: &Renderer) -> Result<String> {
    if let Some(violation) = device.check().first() {
        return Err(Error::new(format!("the device that looks is not synchronized: {violation}")));
    }
    if let Some(message) = renderer.take_messages().first() {
        return Err(Error::new(format!("validation: {message}")));
    }
    let [all, unsure] = device.looked();
    let share = 100.0 * unsure as f64 / (all as f64).max(1.0);
    Ok(format!("; {all} segments, {share:.2} % of them decided by the CPU"))
}
