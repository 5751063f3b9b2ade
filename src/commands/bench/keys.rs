//! A camera path: keys in a JSON file, and where the camera is between them.
//!
//! Positions follow a cubic Hermite spline whose slope at a key is the difference of its neighbours over their times (Catmull and Rom,
//! "A class of local interpolating splines", 1974, for keys at any times); the field of view changes linearly.

use std::path::Path;

use glam::DVec3;
use serde_json::{Map, Value};

use crate::error::{Error, Result};

/// The path through the atrium.
const OWN: (&str, &str) =
    ("assets/paths/atrium.json", include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/paths/atrium.json")));

/// Most poses of a path.
const MOST_POSES: f64 = 10_000.0;

/// Seconds and metres beyond which a file means something else.
const FARTHEST: f64 = 1e9;

/// A camera at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    /// Seconds.
    pub(super) time: f64,
    /// Eye, metres.
    pub(super) from: DVec3,
    /// Point in the middle of the picture.
    pub(super) at: DVec3,
    /// Vertical, degrees.
    pub(super) fov: f64,
}

/// A camera's way.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CameraPath {
    /// The file, as it was typed.
    pub(super) name: String,
    /// One a frame.
    pub(super) poses: Vec<Pose>,
}

impl CameraPath {
    /// Reads a file; without one, the path through the atrium.
    ///
    /// # Errors
    /// A file that cannot be read or is not a path; file, field and index are named.
    pub(super) fn load(file: Option<&Path>) -> Result<Self> {
        let Some(file) = file else { return Self::parse(OWN.0, OWN.1) };
        let name = file.display().to_string();
        let text = std::fs::read_to_string(file).map_err(|e| Error::new(format!("{name}: could not be read: {e}")))?;
        Self::parse(&name, &text)
    }

    fn parse(name: &str, text: &str) -> Result<Self> {
        let poses = poses(text).map_err(|what| Error::new(format!("{name}: {what}")))?;
        Ok(Self { name: name.into(), poses })
    }
}

/// What a file says, or what is wrong with it.
type Read<T> = std::result::Result<T, String>;

fn poses(text: &str) -> Read<Vec<Pose>> {
    let value: Value = serde_json::from_str(text).map_err(|e| format!("is not JSON: {e}"))?;
    let file = object(&value, "the file", &["frames_per_second", "keys"])?;
    let rate = number(file.get("frames_per_second"), "frames_per_second")?;
    if !(rate > 0.0 && rate <= 1000.0) {
        return Err(format!("frames_per_second is {rate}, not above 0 and at most 1000"));
    }
    let Some(Value::Array(list)) = file.get("keys") else { return Err("keys is not a list".into()) };
    let keys = list.iter().enumerate().map(|(index, key)| read_key(key, index)).collect::<Read<Vec<Pose>>>()?;
    let [first, .., last] = keys.as_slice() else {
        return Err(format!("keys has {} of at least 2 elements", keys.len()));
    };
    if let Some(index) = (1..keys.len()).find(|&i| keys[i].time <= keys[i - 1].time) {
        let (time, before) = (keys[index].time, keys[index - 1].time);
        return Err(format!("keys[{index}].time is {time}, not after the {before} of the key before it"));
    }
    // A frame that rounding would lose at the end is kept.
    let steps = ((last.time - first.time) * rate + 1e-6).floor();
    if steps >= MOST_POSES {
        return Err(format!("{} s at {rate} frames a second pass {MOST_POSES} frames", last.time - first.time));
    }
    let at = |step: u32| between(&keys, first.time + f64::from(step) / rate);
    let poses: Vec<Pose> = (0..=steps as u32).map(at).collect();
    match poses.iter().find(|pose| pose.from == pose.at) {
        Some(pose) => Err(format!("after {} s the eye is where it looks", pose.time)),
        None => Ok(poses),
    }
}

fn read_key(value: &Value, index: usize) -> Read<Pose> {
    let name = |field: &str| format!("keys[{index}].{field}");
    let key = object(value, &format!("keys[{index}]"), &["time", "from", "at", "fov"])?;
    let pose = Pose {
        time: number(key.get("time"), &name("time"))?,
        from: point(key.get("from"), &name("from"))?,
        at: point(key.get("at"), &name("at"))?,
        fov: number(key.get("fov"), &name("fov"))?,
    };
    if !(pose.fov > 0.0 && pose.fov < 180.0) {
        return Err(format!("{} is {}, not an angle between 0 and 180 degrees", name("fov"), pose.fov));
    }
    if pose.from == pose.at {
        return Err(format!("{} is where {} is: that gives no direction", name("at"), name("from")));
    }
    Ok(pose)
}

/// An object with exactly these fields.
fn object<'a>(value: &'a Value, what: &str, fields: &[&str]) -> Read<&'a Map<String, Value>> {
    let Value::Object(map) = value else { return Err(format!("{what} is not an object")) };
    if let Some(unknown) = map.keys().find(|key| !fields.contains(&key.as_str())) {
        return Err(format!("{what} has an unknown field \"{unknown}\"; known: {}", fields.join(", ")));
    }
    match fields.iter().find(|field| !map.contains_key(**field)) {
        Some(missing) => Err(format!("{what} has no field \"{missing}\"")),
        None => Ok(map),
    }
}

fn number(value: Option<&Value>, name: &str) -> Read<f64> {
    match value.and_then(Value::as_f64) {
        Some(x) if x.abs() <= FARTHEST => Ok(x),
        Some(x) => Err(format!("{name} is {x:e}, beyond {FARTHEST:e}")),
        None => Err(format!("{name} is not a number")),
    }
}

fn point(value: Option<&Value>, name: &str) -> Read<DVec3> {
    let Some(Value::Array(list)) = value else { return Err(format!("{name} is not a list of three numbers")) };
    let [x, y, z] = list.as_slice() else {
        return Err(format!("{name} has {} elements, a point has three", list.len()));
    };
    let part = |index: usize, value| number(Some(value), &format!("{name}[{index}]"));
    Ok(DVec3::new(part(0, x)?, part(1, y)?, part(2, z)?))
}

/// The camera at a time between the first key and the last; there are at least two.
fn between(keys: &[Pose], time: f64) -> Pose {
    let index = keys.iter().rposition(|key| key.time <= time).unwrap_or(0).min(keys.len() - 2);
    let (a, b) = (&keys[index], &keys[index + 1]);
    let length = b.time - a.time;
    let u = ((time - a.time) / length).clamp(0.0, 1.0);
    let (u2, u3) = (u * u, u * u * u);
    let place = |of: fn(&Pose) -> DVec3| {
        let ends = of(a) * (2.0 * u3 - 3.0 * u2 + 1.0) + of(b) * (3.0 * u2 - 2.0 * u3);
        ends + slope(keys, index, of) * (length * (u3 - 2.0 * u2 + u))
            + slope(keys, index + 1, of) * (length * (u3 - u2))
    };
    Pose { time, from: place(|pose| pose.from), at: place(|pose| pose.at), fov: a.fov + (b.fov - a.fov) * u }
}

/// Metres a second at a key; one-sided at both ends.
fn slope(keys: &[Pose], index: usize, of: fn(&Pose) -> DVec3) -> DVec3 {
    let (before, after) = (&keys[index.saturating_sub(1)], &keys[(index + 1).min(keys.len() - 1)]);
    (of(after) - of(before)) / (after.time - before.time)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, x: f64) -> String {
        format!("{{\"time\": {time}, \"from\": [{x}, 2, 0], \"at\": [{x}, 2, -5], \"fov\": {}}}", 60.0 + time.min(9.0))
    }

    fn file(keys: &[String]) -> String {
        format!("{{\"frames_per_second\": 10, \"keys\": [{}]}}", keys.join(", "))
    }

    fn refused(text: &str) -> String {
        CameraPath::parse("way.json", text).expect_err(text).to_string()
    }

    #[test]
    fn the_own_path_is_one_of_about_three_seconds() {
        let path = CameraPath::load(None).expect("the atrium's path");
        assert_eq!(path.name, "assets/paths/atrium.json");
        assert!((25..=40).contains(&path.poses.len()), "{}", path.poses.len());
        assert!(path.poses.windows(2).all(|p| (p[1].time - p[0].time - 0.1).abs() < 1e-9));
        // Inside of the court of 30 m x 14 m, above the floor, and steady.
        assert!(path.poses.iter().all(|p| p.from.x.abs() < 14.0 && p.from.z.abs() < 6.5 && p.from.y > 0.5));
        assert!(path.poses.windows(2).all(|p| (p[1].from - p[0].from).length() < 1.5));
    }

    #[test]
    fn keys_are_met_and_equal_speed_is_kept() {
        let path = CameraPath::parse("a", &file(&[key(0.0, 0.0), key(0.5, 1.0), key(2.0, 4.0)])).expect("a path");
        assert_eq!(path.poses.len(), 21);
        for (index, pose) in path.poses.iter().enumerate() {
            let time = index as f64 * 0.1;
            assert!((pose.time - time).abs() < 1e-12 && (pose.from.x - 2.0 * time).abs() < 1e-9, "{pose:?}");
            assert!((pose.fov - 60.0 - time).abs() < 1e-9 && (pose.at.z + 5.0).abs() < 1e-9, "{pose:?}");
        }
    }

    #[test]
    fn a_turning_point_is_smooth() {
        let keys = [0.0, 1.0, 2.0].map(|time| key(time, if time == 1.0 { 3.0 } else { 0.0 }));
        let path = CameraPath::parse("a", &file(&keys)).expect("a path");
        let x = |index: usize| path.poses[index].from.x;
        assert_eq!(x(10), 3.0);
        assert!((x(9) - x(11)).abs() < 1e-9, "the slope at the middle key is 0");
        assert!(3.0 - x(9) < 0.1 && x(5) > 1.5);
    }

    #[test]
    fn what_is_wrong_is_named_with_file_field_and_index() {
        let good = [key(0.0, 0.0), key(1.0, 1.0)];
        let swap = |from: &str, to: &str| refused(&file(&good).replacen(from, to, 1));
        for (said, words) in [
            (refused("{"), "way.json: is not JSON"),
            (refused("[]"), "way.json: the file is not an object"),
            (swap("10", "0"), "frames_per_second is 0, not above 0"),
            (swap("10", "\"10\""), "frames_per_second is not a number"),
            (swap("\"keys\"", "\"kyes\""), "unknown field \"kyes\""),
            (refused(&file(&good[..1])), "keys has 1 of at least 2 elements"),
            (refused(&file(&[key(1.0, 0.0), key(1.0, 1.0)])), "keys[1].time is 1, not after the 1"),
            (swap("\"fov\": 61", "\"fov\": 180"), "keys[1].fov is 180, not an angle"),
            (swap(", \"fov\": 61", ""), "keys[1] has no field \"fov\""),
            (swap("[1, 2, 0]", "[1, 2]"), "keys[1].from has 2 elements"),
            (swap("[1, 2, 0]", "[1, null, 0]"), "keys[1].from[1] is not a number"),
            (swap("[1, 2, 0]", "[1e10, 2, 0]"), "keys[1].from[0] is 1e10, beyond 1e9"),
            (swap("[0, 2, -5]", "[0, 2, 0]"), "keys[0].at is where keys[0].from is"),
            (refused(&file(&[key(0.0, 0.0), key(1e6, 1.0)])), "frames a second pass 10000 frames"),
        ] {
            assert!(said.starts_with("way.json: ") && said.contains(words), "{said} lacks {words}");
        }
        assert!(CameraPath::load(Some(Path::new("/nonexistent/way.json"))).is_err());
    }
}
