//! C2, C3, C5, C6, C8 and T6 for clusters: cameras, lights and sizes at which slices are few, linear, unbounded or cut.

use glam::DVec3;

use super::{KINDS, differing, of_kind, parts, radiance, request, rows_of, scene};
use crate::checks::Row;
use crate::error::Result;
use crate::plan::{CameraChoice, Limits, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::{Projection, Scene};

/// A scene, how it is asked for, and the number of slices that it must have, where that is the point.
struct Case {
    name: &'static str,
    scene: Scene,
    request: Request,
    slices: Option<u32>,
}

impl Case {
    fn new(name: &'static str, scene: Scene) -> Self {
        let request = Request { width: 96, height: 54, ..request(Technique::Forward) };
        Self { name, scene, request, slices: None }
    }

    /// Seen through another lens, from where the scene's first camera stands.
    fn through(name: &'static str, mut scene: Scene, projection: Projection) -> Self {
        scene.cameras.truncate(1);
        for camera in &mut scene.cameras {
            camera.projection = projection;
        }
        Self::new(name, scene)
    }

    fn rows(&self, renderer: &Renderer) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        let forward = radiance(renderer, &self.scene, &self.request)?;
        for kind in KINDS {
            let asked = of_kind(&self.request, kind);
            let count = differing(&forward, &radiance(renderer, &self.scene, &asked)?);
            let name = format!("{}, {}", self.name, kind.0);
            rows.push(Row::none(format!("{name}, clustered-forward = forward"), count, "differing pixels"));
        }
        let asked = of_kind(&self.request, KINDS[0]);
        if self.scene.lights.is_empty() {
            let plan = Plan::new(&self.scene, &asked, &renderer.limits())?;
            let made = usize::from(plan.tiles.is_some()) + usize::from(plan.clusters.is_some());
            rows.push(Row::none(format!("{}, nothing is listed", self.name), made, "grids"));
            return Ok(rows);
        }
        rows.extend(rows_of(renderer, self.name, &self.scene, &asked)?);
        if let Some(wanted) = self.slices {
            let plan = Plan::new(&self.scene, &of_kind(&self.request, KINDS[0]), &renderer.limits())?;
            let found = parts(&plan)?.1.grid.slices;
            let wrong = usize::from(found != wanted);
            rows.push(Row::none(format!("{}, {found} slices", self.name), wrong, "plans"));
        }
        Ok(rows)
    }
}

/// The room is 5.5 m wide; the camera stands 10.6 m from its middle, so it sees from 7.85 m to 13.35 m.
fn room(lights: usize) -> Result<Scene> {
    scene("cornell", lights)
}

fn perspective(znear: f64, zfar: Option<f64>) -> Projection {
    Projection::Perspective { yfov: 0.69, aspect: None, znear, zfar }
}

fn orthographic(znear: f64, zfar: f64) -> Projection {
    Projection::Orthographic { xmag: 5.0, ymag: 3.0, znear, zfar }
}

/// Few slices (C2), linear ones (C3), and one without an end (C5).
fn lenses() -> Result<Vec<Case>> {
    let one = |case: Case| Case { slices: Some(1), ..case };
    let mut single = Case::through("C2 one slice", room(96)?, perspective(10.0, None));
    single.request.tile = 64;
    let mut above = Case::new("C2 camera straight down", room(96)?);
    above.request.camera = CameraChoice::LookAt(DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO, 1.3);
    Ok(vec![
        one(Case::through("C2 near is nearly far", room(96)?, perspective(10.0, Some(10.1)))),
        one(single),
        one(Case::through("C2 nothing behind near", room(96)?, perspective(100.0, None))),
        above,
        Case::through("C3 orthographic, near 0", room(96)?, orthographic(0.0, 20.0)),
        Case::through("C3 orthographic, near -4", room(96)?, orthographic(-4.0, 20.0)),
        Case::through("C5 lights beyond far", room(96)?, perspective(0.05, Some(11.0))),
        Case::through("C5 lights beyond far, orthographic", room(96)?, orthographic(0.0, 11.0)),
    ])
}

/// Numbers of lights and where they are (C8), and sizes of the picture (T6).
fn counts() -> Result<Vec<Case>> {
    let mut heap = room(33)?;
    for light in &mut heap.lights {
        light.position = DVec3::new(0.5, 2.0, 1.5);
    }
    let sized = |name: &'static str, width: u32, height: u32| -> Result<Case> {
        let mut case = Case::new(name, room(96)?);
        (case.request.width, case.request.height) = (width, height);
        Ok(case)
    };
    Ok(vec![
        Case::new("C8 no light", room(0)?),
        Case::new("C8 1 light", room(1)?),
        Case::new("C8 33 lights", room(33)?),
        Case::new("C8 33 lights at one point", heap),
        sized("T6 1x1", 1, 1)?,
        sized("T6 15x17", 15, 17)?,
        sized("T6 129x65", 129, 65)?,
    ])
}

/// C6: what keys take in pictures of many tiles; past 32 bits the plan refuses (its own tests).
fn keys() -> Result<Vec<Row>> {
    let scene = room(8)?;
    let row = |[width, height, tile]: [u32; 3]| -> Result<Row> {
        let asked = Request { width, height, tile, ..request(Technique::ClusteredForward) };
        let bits = parts(&Plan::new(&scene, &asked, &Limits::UNLIMITED)?)?.1.key_bits;
        let name = format!("C6 keys of {width}x{height}, tile {tile}");
        Ok(Row { name, passed: bits <= 32, detail: format!("{bits} bits of 32") })
    };
    [[3840, 2160, 16], [16_384, 16_384, 8]].map(row).into_iter().collect()
}

/// The rows of the table of hard cases that clusters can break.
pub fn cluster_cases(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = keys()?;
    for case in lenses()?.into_iter().chain(counts()?) {
        rows.extend(case.rows(renderer)?);
    }
    Ok(rows)
}
