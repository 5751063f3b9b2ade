//! A device under validation and synchronization validation for every test; a test that cannot have one says so, and fails
//! where `LAMPYRIS_REQUIRE_GPU=1`.

use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};

use lampyris::checks;
use lampyris::gpu::Options;
use lampyris::gpu::instance::Messages;
use lampyris::renderer::Renderer;

/// Drivers draw one picture at a time here: two cores gain nothing from more.
static TURN: OnceLock<Mutex<()>> = OnceLock::new();

/// A renderer with validation on; dropping it asserts that no message came, not even while the device was destroyed.
pub struct Gpu {
    renderer: Option<Renderer>,
    messages: Arc<Messages>,
    _turn: MutexGuard<'static, ()>,
}

/// A validated device, or `None` where there is none and none is required.
pub fn gpu() -> Option<Gpu> {
    let turn = TURN.get_or_init(Mutex::default).lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    match Renderer::new(&Options { validate: true, driver: None }) {
        Ok(renderer) => Some(Gpu { messages: renderer.messages(), renderer: Some(renderer), _turn: turn }),
        Err(error) if std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1") => {
            panic!("LAMPYRIS_REQUIRE_GPU=1, but: {error}")
        }
        Err(error) => {
            eprintln!("SKIPPED, no device: {error}");
            None
        }
    }
}

impl Deref for Gpu {
    type Target = Renderer;

    fn deref(&self) -> &Renderer {
        self.renderer.as_ref().expect("there until it is dropped")
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        self.renderer = None;
        let messages = self.messages.take();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}

/// Runs the check of that name and asserts every row of it.
pub fn run(name: &str) {
    let Some(gpu) = gpu() else { return };
    let check = checks::ALL.iter().find(|c| c.0 == name).expect("a check of that name").1;
    let rows = check(&gpu).expect("the check runs");
    assert!(!rows.is_empty());
    for row in &rows {
        println!("{}: {}", row.name, row.detail);
    }
    let failed: Vec<_> = rows.iter().filter(|r| !r.passed).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
