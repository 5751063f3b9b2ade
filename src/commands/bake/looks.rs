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
    on: BakeOnArg,
    options: Options,
}

impl Looks {
    /// As typed.
    ///
    /// # Errors
    /// Options of a device where none is to be used.
    pub fn new(on: BakeOnArg, options: Options) -> Result<Self> {
        if on == BakeOnArg::Cpu && (options.validate || options.driver.is_some()) {
            return Err(Error::usage("--driver and --validate are options of --bake-on auto and --bake-on device"));
        }
        Ok(Self { on, options })
    }

    /// Whatever is quicker.
    pub fn auto(driver: Option<&str>) -> Self {
        Self { on: BakeOnArg::Auto, options: Options { validate: false, driver: driver.map(Into::into) } }
    }

    /// Something was said of the device: it has to be there.
    fn is_meant(&self) -> bool {
        self.on == BakeOnArg::Device || self.options.validate || self.options.driver.is_some()
    }

    /// The device, where one is asked for or may be worth it.
    ///
    /// # Errors
    /// None, where one is asked for.
    pub fn renderer(&self, patches: usize) -> Result<Option<Renderer>> {
        if self.on == BakeOnArg::Cpu || (!self.is_meant() && patches < FEWEST) {
            return Ok(None);
        }
        match Renderer::new(&self.options) {
            Err(error) if self.is_meant() => Err(error),
            opened => Ok(opened.ok()),
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
        let name = &renderer.device().facts.name;
        let tried = renderer.sight(reference, patches.off_surface).and_then(|device| {
            let times =
                if self.on == BakeOnArg::Device { None } else { Some(times(&device, reference, patches, seed)?) };
            Ok((device, times))
        });
        match tried {
            Err(error) if self.is_meant() => Err(error),
            Err(error) => Ok((None, format!("CPU: {error}"))),
            Ok((device, None)) => Ok((Some(device), name.clone())),
            Ok((device, Some([on_device, on_cpu]))) => {
                let measured = format!("{TRIED} rows in {on_device:.0} ms on {name}, in {on_cpu:.0} ms on the CPU");
                judged(&device, renderer)?;
                device.forget_looked();
                let quicker = on_device < on_cpu;
                let who = if quicker { name.as_str() } else { "CPU" };
                Ok((quicker.then_some(device), format!("{who}: {measured}")))
            }
        }
    }
}

/// Milliseconds for a few rows on the device and on the CPU.
fn times(device: &DeviceSight, reference: &Reference, patches: &Patches, seed: u64) -> Result<[f64; 2]> {
    let count = patches.list.len();
    let first = count.saturating_sub(TRIED) / 2;
    let time = |sight: &dyn Sight| -> Result<f64> {
        let start = Instant::now();
        RawRows::new(patches, sight, seed, first..(first + TRIED).min(count), &|| {})?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    };
    // The first batch of a driver on the CPU compiles.
    time(device)?;
    Ok([time(device)?, time(reference)?])
}

/// Whether what a device has done so far is synchronized, and without a message of the validation layer.
///
/// # Errors
/// What is wrong.
pub fn judged(device: &DeviceSight, renderer: &Renderer) -> Result<()> {
    if let Some(violation) = device.check().first() {
        return Err(Error::new(format!("the device that looks is not synchronized: {violation}")));
    }
    match renderer.take_messages().first() {
        Some(message) => Err(Error::new(format!("validation: {message}"))),
        None => Ok(()),
    }
}

/// For people: what a device has looked at.
pub fn looked(device: &DeviceSight) -> String {
    let [all, unsure] = device.looked();
    let share = 100.0 * unsure as f64 / (all as f64).max(1.0);
    format!("; {all} segments, {share:.2} % of them decided by the CPU")
}
