//! A device under validation and synchronization validation for every test; a test that cannot have one says so, and fails
//! where `LAMPYRIS_REQUIRE_GPU=1`.

use std::f64::consts::TAU;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};

use glam::DVec3;
use lampyris::checks;
use lampyris::gpu::Options;
use lampyris::gpu::instance::Messages;
use lampyris::math::random::Random;
use lampyris::renderer::Renderer;
use lampyris::scene::{Light, LightKind, Scene, builtin};

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

/// A room with 64 lights beside an eye in its middle that looks along -Z. Each is 3e-4 of its range ahead, so the textbook's rectangle,
/// which divides by that, loses some of those that reach the wall in front.
pub fn lights_beside_the_eye() -> Scene {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    let mut random = Random::new(1);
    let light = |index: usize| {
        let range = random.range(2.5, 5.0) as f32;
        let radius = f64::from(range);
        let (sine, cosine) = random.range(0.0, TAU).sin_cos();
        let aside = radius * random.range(1.01, 1.3);
        Light {
            name: format!("light {index}"),
            kind: LightKind::Point,
            color: [1.0; 3],
            intensity: 1.0,
            position: DVec3::new(aside * cosine, aside * sine, -3e-4 * radius),
            direction: DVec3::NEG_Z,
            range: Some(range),
            shadow: false,
        }
    };
    scene.lights = (0..64).map(light).collect();
    scene
}
