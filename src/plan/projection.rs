//! The rectangle of the screen that a light's sphere covers, and the distances it spans.
//!
//! Per axis of the picture the sphere is seen as its profile: the disc that it casts on the plane of that axis ("across") and the view
//! direction ("ahead"). A point's image depends on across / ahead alone and the near plane on ahead alone, so the extent of the clipped
//! disc is that of the clipped sphere. Its ends are the tangents through the eye or, where a tangent touches the disc before the near
//! plane, the ends of the chord in which that plane cuts the disc. No step divides by the light's own depth: the tangents are
//! directions, and one division by a direction's own `ahead`, proved positive, ends the calculation.
//!
//! All of it is f32. Why the rectangle contains the exact one of the f64 sphere:
//!
//! 1. The f32 disc contains the exact disc. Scaling by a power of two is exact; the centre moves by at most `moved`, computed with an
//!    error of 2^-52, and the radius grows by `moved`, is rounded up and then raised by another ulp, 2^-24 of itself or more. The near
//!    plane is rounded towards the eye, by an ulp at least. From there on the f32 disc and plane are exact numbers.
//! 2. `below(x op y)` and `above(x op y)` lie on their side of the exact result: rounding to nearest is off by at most half the gap to
//!    the neighbour that they return, with underflow and overflow too. Every operation is wrapped in the one that moves the result
//!    outward, so the margin is an ulp an operation and needs no constant.
//! 3. With `t` the tangent's length, t^2 = across^2 + ahead^2 - radius^2, the tangent's slope is (c t + a r) / (a t - c r): with k = r / t,
//!    (c + a k) / (a - c k). Its derivative by k has the sign of a^2 + c^2, so a lower bound of t gives an upper bound of the slope,
//!    provided that a - c k stays positive between the exact k and the larger one used. It is linear in k and the larger k is
//!    checked. The exact k has it positive whenever a part of the disc is ahead of the eye and the larger k has it so: for a > 0 the
//!    line is positive at k = 0 and at the larger k; for a <= 0 the check implies c < 0, and a disc that reaches ahead has r > -a,
//!    so (c r)^2 - (a t)^2 = (c^2 + a^2)(r^2 - a^2) > 0.
//! 4. The chord's end E = (c + h, n) is the extreme exactly where the line from the eye through E leaves the disc at E, that is where E
//!    lies on or beyond the eye's polar line: E . C >= t^2, or c h + a n + r^2 - a^2 >= 0. Only a proved sign counts. Where the whole disc
//!    lies beyond the plane the chord does not exist, a > r + n makes a n + r^2 - a^2 negative and the code adds c times 0 for
//!    c >= 0 and a negative number for c < 0: never proved.
//! 5. Either bound holds, so the smaller is taken; where neither is proved the answer is infinite, up to the edge of the picture.
//!
//! What that wastes: the edge of the picture is the answer where the eye is outside the sphere by less than about 2^-22 of its radius; and
//! an edge of a sphere that the near plane cuts is off by about 2^-22 of |c| / znear, more than a pixel for radii of thousands of
//! near distances. A sphere that the far plane cuts keeps the rectangle it would have without (perspective lenses).

use glam::{DVec3, Vec3};

use crate::scene::view::{Lens, View};

/// Closed rectangle in pixels, x to the right from the left edge of column 0, y down from the upper edge of row 0; clamped to the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRect {
    /// Left and right.
    pub x: [f32; 2],
    /// Upper and lower.
    pub y: [f32; 2],
}

/// The rectangle that encloses the visible part of a sphere, or None where nothing of it can be seen.
///
/// `center` is in view space. The whole picture where the radius or the centre is not finite, or the eye is inside the sphere or
/// within an ulp (f32) of its surface.
pub fn tangent_rectangle(center: DVec3, radius: f64, view: &View) -> Option<PixelRect> {
    distance_range(center, radius, view)?;
    let [horizontal, vertical] = PictureAxis::both(view);
    let whole = PixelRect { x: [0.0, horizontal.size], y: [0.0, vertical.size] };
    if !(radius.is_finite() && center.is_finite()) {
        return Some(whole);
    }
    let [across, up] = match view.lens {
        Lens::Perspective(_) => {
            if center.length() <= radius * (1.0 + f64::from(f32::EPSILON)) {
                return Some(whole);
            }
            [center.x, center.y].map(|c| Profile::new(c, -center.z, radius, view.znear).slopes())
        }
        Lens::Orthographic(_) => {
            let half = half_width(-center.z, radius, view);
            [center.x, center.y].map(|c| [below(rounded_down(c) - half), above(rounded_up(c) + half)])
        }
    };
    Some(PixelRect { x: horizontal.pixels(across)?, y: vertical.pixels(up)? })
}

/// Nearest and farthest distance along -Z of the sphere's part between znear and zfar, rounded outward to f32; None where it has none.
///
/// A sphere that only touches either plane, as far as f64 can tell, is kept. A negative radius has no sphere.
pub fn distance_range(center: DVec3, radius: f64, view: &View) -> Option<[f32; 2]> {
    let (near, far) = (view.znear, view.zfar.unwrap_or(f64::INFINITY));
    let ahead = -center.z;
    let (first, last) = ((ahead - radius).next_down(), (ahead + radius).next_up());
    if radius < 0.0 || last < near || first > far {
        return None;
    }
    Some([rounded_down(first.max(near)), rounded_up(last.min(far))])
}

/// Inclusive ranges [x0, x1, y0, y1] of the tiles that a rectangle owns; `tile` is an edge's length in pixels.
///
/// A closed rectangle that touches the edge between two tiles owns both.
pub fn rectangle_tiles(rect: &PixelRect, tile: u32, columns: u32, rows: u32) -> [u32; 4] {
    let range = |[low, high]: [f32; 2], count: u32| {
        // A quotient that is not a whole number is at least 2^-25 of itself away from one: f64 keeps it on its side.
        let tiles = |pixels: f32| f64::from(pixels) / f64::from(tile.max(1));
        let last = count.saturating_sub(1);
        [((tiles(low).ceil() - 1.0) as u32).min(last), (tiles(high).floor() as u32).min(last)]
    };
    let ([x0, x1], [y0, y1]) = (range(rect.x, columns), range(rect.y, rows));
    [x0, x1, y0, y1]
}

/// The textbook form: division by L_z and N_x in f32, kept to show what it loses.
///
/// Lengyel's scissor rectangle ("The Mechanics of Robust Stencil Shadows", 2002): the unit normal (N_x, N_z) of a plane through the eye and
/// tangent to the sphere has N_x L_x + N_z L_z = r, a quadratic in N_x; likewise for y. Nothing guards the divisions. Orthographic
/// lenses, which the form does not cover, get centre and radius.
pub fn textbook_rectangle(center: Vec3, radius: f32, view: &View) -> Option<PixelRect> {
    if center.z - radius > -(view.znear as f32) {
        return None;
    }
    let extent = |across: f32, first: f64, last: f64, size: u32| {
        let slopes = match view.lens {
            Lens::Perspective(_) => textbook_slopes(across, center.z, radius),
            Lens::Orthographic(_) => [across - radius, across + radius],
        };
        let scale = size as f32 / (last as f32 - first as f32);
        let [a, b] = slopes.map(|slope| (slope - first as f32) * scale);
        let pixels = [a.min(b).max(0.0), a.max(b).min(size as f32)];
        (pixels[0] <= pixels[1]).then_some(pixels)
    };
    let e = view.lens.extents();
    Some(PixelRect {
        x: extent(center.x, e.left, e.right, view.width)?,
        y: extent(center.y, e.top, e.bottom, view.height)?,
    })
}

/// Lower and upper bound of across / -z; infinite on a side where no tangent point in front of the eye bounds it.
fn textbook_slopes(across: f32, z: f32, radius: f32) -> [f32; 2] {
    let squared = across * across + z * z;
    let discriminant = radius * radius * across * across - squared * (radius * radius - z * z);
    let mut slopes = [f32::NEG_INFINITY, f32::INFINITY];
    if discriminant <= 0.0 {
        return slopes;
    }
    for root in [discriminant.sqrt(), -discriminant.sqrt()] {
        let normal_across = (radius * across + root) / squared;
        let normal_z = (radius - normal_across * across) / z;
        let slope = normal_z / normal_across;
        let touch_z = (squared - radius * radius) / (z - slope * across);
        if touch_z < 0.0 {
            if -touch_z * slope < across {
                slopes[0] = slopes[0].max(slope);
            } else {
                slopes[1] = slopes[1].min(slope);
            }
        }
    }
    slopes
}

/// The neighbour under a rounded result: at most the exact one.
fn below(rounded: f32) -> f32 {
    rounded.next_down()
}

/// The neighbour over a rounded result: at least the exact one.
fn above(rounded: f32) -> f32 {
    rounded.next_up()
}

/// The greatest f32 that is at most `x`.
fn rounded_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The least f32 that is at least `x`.
fn rounded_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// At most x^2 - y^2, for x and y of at least 0; exact to a few ulp where they nearly agree.
fn least_difference_of_squares(x: f32, y: f32) -> f32 {
    if x >= y { below(below(x - y) * below(x + y)) } else { -above(above(y - x) * above(y + x)) }
}

/// One axis of the picture: pixels = scale * image coordinate + offset, each of the two between two bounds.
struct PictureAxis {
    scale: [f32; 2],
    offset: [f32; 2],
    size: f32,
}

impl PictureAxis {
    /// Columns and rows; rows run downwards, so they begin at the top.
    fn both(view: &View) -> [Self; 2] {
        let e = view.lens.extents();
        [Self::new(e.left, e.right, view.width), Self::new(e.top, e.bottom, view.height)]
    }

    /// `first` and `last` are the image coordinates of the pixel coordinates 0 and `size`; a mirroring lens has a negative scale.
    fn new(first: f64, last: f64, size: u32) -> Self {
        // The ulp added, 2^-24 or more of each, exceeds the three roundings in f64.
        let around = |x: f64| [below(rounded_down(x)), above(rounded_up(x))];
        let scale = f64::from(size) / (last - first);
        Self { scale: around(scale), offset: around(-first * scale), size: size as f32 }
    }

    /// Pixels that contain every image coordinate between two, or None where all of them are outside the picture.
    fn pixels(&self, coordinates: [f32; 2]) -> Option<[f32; 2]> {
        let (mut first, mut last) = (f32::INFINITY, f32::NEG_INFINITY);
        for scale in self.scale {
            for coordinate in coordinates {
                first = first.min(scale * coordinate);
                last = last.max(scale * coordinate);
            }
        }
        let (first, last) = (below(below(first) + self.offset[0]), above(above(last) + self.offset[1]));
        if first > self.size || last < 0.0 {
            return None;
        }
        Some([first.max(0.0), last.min(self.size)])
    }
}

/// At least half the width of the sphere's part between znear and zfar, seen along the view direction.
fn half_width(ahead: f64, radius: f64, view: &View) -> f32 {
    let outside = (view.znear - ahead).max(ahead - view.zfar.unwrap_or(f64::INFINITY)).max(0.0);
    // An ulp each, 2^-24, exceeds the rounding of the difference in f64; the sphere reaches as far in, so the product is not negative.
    let (outside, radius) = (below(rounded_down(outside)).max(0.0), above(rounded_up(radius)));
    above(above(above(radius - outside) * above(radius + outside)).max(0.0).sqrt())
}

/// A disc and the near plane, scaled by a power of two so that no square overflows.
#[derive(Clone, Copy)]
struct Profile {
    across: f32,
    ahead: f32,
    radius: f32,
    near: f32,
}

impl Profile {
    /// All finite; one of the first three is not 0 or subnormal.
    fn new(across: f64, ahead: f64, radius: f64, near: f64) -> Self {
        let largest = across.abs().max(ahead.abs()).max(radius);
        // Exponent bits alone: the power of two at or under `largest`.
        let unit = f64::from_bits(largest.to_bits() & 0x7FF0_0000_0000_0000);
        let [across, ahead, radius, near] = [across, ahead, radius, near].map(|x| x / unit);
        let rounded = [across as f32, ahead as f32];
        let moved = (across - f64::from(rounded[0])).abs() + (ahead - f64::from(rounded[1])).abs();
        Self {
            across: rounded[0],
            ahead: rounded[1],
            radius: above(rounded_up(radius + moved)),
            near: below(rounded_down(near)),
        }
    }

    /// Bounds of across / ahead over the disc's part at the near plane or farther ahead.
    fn slopes(&self) -> [f32; 2] {
        let mirrored = Self { across: -self.across, ..*self };
        [-mirrored.largest_slope(), self.largest_slope()]
    }

    fn largest_slope(&self) -> f32 {
        self.tangent_slope().min(self.chord_slope())
    }

    /// At least the slope of the tangent on the side of positive `across`; infinite where it is not proved to lead ahead.
    fn tangent_slope(&self) -> f32 {
        let Self { across, ahead, radius, .. } = *self;
        let (long, short) = (across.abs().max(ahead.abs()), across.abs().min(ahead.abs()));
        let power = below(least_difference_of_squares(long, radius) + below(short * short));
        if power <= 0.0 {
            return f32::INFINITY;
        }
        let length = below(power.sqrt());
        let leads_ahead = [
            below(below(ahead * length) - above(across * radius)),
            above(above(ahead * length) - below(across * radius)),
        ];
        if leads_ahead[0] <= 0.0 {
            return f32::INFINITY;
        }
        let leads_across = above(above(across * length) + above(ahead * radius));
        above(leads_across / if leads_across > 0.0 { leads_ahead[0] } else { leads_ahead[1] })
    }

    /// At least the slope of the chord's end on the side of positive `across`; infinite where it is not proved to be the extreme.
    fn chord_slope(&self) -> f32 {
        let Self { across, ahead, radius, near } = *self;
        let offset = [below(ahead - near), above(ahead - near)];
        // Heights of the disc's parts beyond the plane and before it: the square of half the chord is their product.
        let beyond = [below(radius + offset[0]), above(radius + offset[1])];
        let before = [below(radius - offset[1]), above(radius - offset[0])];
        if beyond[1] < 0.0 || before[1] < 0.0 || near <= 0.0 {
            return f32::INFINITY;
        }
        let most = above(above(beyond[1] * before[1]).sqrt());
        let least = if beyond[0] > 0.0 && before[0] > 0.0 {
            below(below(beyond[0] * before[0]).max(0.0).sqrt()).max(0.0)
        } else {
            0.0
        };
        let past_polar = below(least_difference_of_squares(radius, ahead.abs()) + below(ahead * near));
        let past_polar = below(past_polar + below(across * if across >= 0.0 { least } else { most }));
        if past_polar < 0.0 {
            return f32::INFINITY;
        }
        above(above(across + most) / near)
    }
}

#[cfg(test)]
mod tests;
