//! A device under validation and synchronization validation for every test; a test that cannot have one says so, and fails
//! where `LAMPYRIS_REQUIRE_GPU=1`.

use std::sync::{Mutex, MutexGuard, OnceLock};

use lampyris::gpu::Options;
use lampyris::renderer::Renderer;

/// Drivers draw one picture at a time here: two cores gain nothing from more.
static TURN: OnceLock<Mutex<()>> = OnceLock::new();

/// A renderer with validation on; dropping it asserts that no message came.
pub struct Gpu {
    pub renderer: Renderer,
    _turn: MutexGuard<'static, ()>,
}

/// A validated device, or `None` where there is none and none is required.
pub fn gpu() -> Option<Gpu> {
    let turn = TURN.get_or_init(Mutex::default).lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    match Renderer::new(&Options { validate: true, driver: None }) {
        Ok(renderer) => Some(Gpu { renderer, _turn: turn }),
        Err(error) if std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1") => {
            panic!("LAMPYRIS_REQUIRE_GPU=1, but: {error}")
        }
        Err(error) => {
            eprintln!("SKIPPED, no device: {error}");
            None
        }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        let messages = self.renderer.take_messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}
