//! Quiet zones: flat areas in front of the array, and their table in the scene file.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::scene::range::{Key, KeyError};
use crate::scene::solver::is_zero;
use crate::scene::target::{facing, is_z};

/// Limit of samples per zone; larger zones are sampled more coarsely.
const MOST_POINTS: f64 = 4096.0;

/// A quiet zone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Zone {
    #[serde(flatten)]
    pub area: Area,
    /// m, its centre.
    pub at: DVec3,
    /// Normal; +z is parallel to the array.
    #[serde(skip_serializing_if = "is_z")]
    pub normal: DVec3,
    /// rad, about its centre.
    #[serde(skip_serializing_if = "is_zero")]
    pub angle: f64,
    /// Weight relative to the rest of the plane.
    pub weight: f64,
}

/// The form of a zone. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Area {
    Circle { radius: f64 },
    Rectangle { width: f64, height: f64 },
    Polygon { radius: f64, sides: u32 },
}

impl Area {
    /// m: half the sides of the box around it.
    fn half(&self) -> DVec2 {
        match *self {
            Self::Circle { radius } | Self::Polygon { radius, .. } => DVec2::splat(radius),
            Self::Rectangle { width, height } => DVec2::new(width, height) / 2.0,
        }
    }

    fn contains(&self, point: DVec2) -> bool {
        match *self {
            Self::Circle { radius } => point.length() <= radius,
            Self::Rectangle { .. } => point.abs().cmple(self.half()).all(),
            Self::Polygon { radius, sides } => {
                // The side nearest to a point follows from its angle, measured from the first corner at the top.
                let side = TAU / f64::from(sides);
                let from_corner = (point.to_angle() - TAU / 4.0).rem_euclid(side);
                point.length() * (from_corner - side / 2.0).cos() <= radius * (side / 2.0).cos()
            }
        }
    }
}

impl Zone {
    /// A zone of this form with everything else at its default.
    pub fn new(area: Area, at: DVec3) -> Self {
        Self { area, at, normal: DVec3::Z, angle: 0.0, weight: 1.0 }
    }

    /// Points (m) on a square grid in the zone, including its centre, `spacing` m apart, or more where
    /// there would be over 4096 points.
    pub fn points(&self, spacing: f64) -> Vec<DVec3> {
        let half = self.area.half();
        let thinnest = (4.0 * half.x * half.y / MOST_POINTS).sqrt();
        let longest = half.max_element() / (MOST_POINTS / 4.0);
        let mut spacing = spacing.max(thinnest).max(longest);
        let steps = |spacing: f64| (half / spacing).floor().as_i64vec2();
        while (2 * steps(spacing) + 1).as_dvec2().element_product() > MOST_POINTS {
            spacing *= 1.05;
        }
        let most = steps(spacing);
        let rows = (-most.y..=most.y).flat_map(|y| (-most.x..=most.x).map(move |x| (x, y)));
        let flat = rows.map(|(x, y)| DVec2::new(x as f64, y as f64) * spacing);
        let turn = self.turn();
        flat.filter(|&point| self.area.contains(point))
            .map(|point| self.at + turn * point.extend(0.0))
            .collect()
    }

    /// The lowest point of its bounding box, or of the circle, along a direction.
    pub(crate) fn lowest(&self, up: DVec3) -> DVec3 {
        let turn = self.turn();
        let (x, y) = ((turn * DVec3::X).dot(up), (turn * DVec3::Y).dot(up));
        let down = match self.area {
            Area::Circle { radius } | Area::Polygon { radius, .. } => radius * x.hypot(y),
            Area::Rectangle { width, height } => (width * x.abs() + height * y.abs()) / 2.0,
        };
        self.at - up * down
    }

    fn turn(&self) -> DQuat {
        facing(self.normal) * DQuat::from_rotation_z(self.angle)
    }
}

/// The `[[quiet]]` table as written: every key of every kind, so that stray keys are reported at their position.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ZoneTable {
    #[serde(default)]
    kind: Kind,
    at: Option<DVec3>,
    radius: Option<f64>,
    width: Option<f64>,
    height: Option<f64>,
    sides: Option<u32>,
    normal: Option<DVec3>,
    angle: Option<f64>,
    weight: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub(super) enum Kind {
    #[default]
    Circle,
    Rectangle,
    Polygon,
}

impl ZoneTable {
    /// The zone of this table, the `index`-th in the file.
    pub(crate) fn into_zone(self, index: usize) -> Result<Zone, KeyError> {
        let Self { kind, at, mut radius, mut width, mut height, mut sides, normal, angle, weight } = self;
        let area = match kind {
            Kind::Circle => Area::Circle { radius: radius.take().unwrap_or(0.02) },
            Kind::Rectangle => {
                Area::Rectangle { width: width.take().unwrap_or(0.04), height: height.take().unwrap_or(0.04) }
            }
            Kind::Polygon => {
                Area::Polygon { radius: radius.take().unwrap_or(0.02), sides: sides.take().unwrap_or(6) }
            }
        };
        let left = [
            ("radius", radius.is_some()),
            ("width", width.is_some()),
            ("height", height.is_some()),
            ("sides", sides.is_some()),
        ];
        if let Some((key, _)) = left.into_iter().find(|(_, given)| *given) {
            return Err(KeyError::new(
                [Key::from("quiet"), Key::from(index), Key::from(key)],
                format!("a zone of kind `{}` has no such key", kind.into_str()),
            ));
        }
        let plain = Zone::new(area, at.unwrap_or(DVec3::new(0.0, 0.0, 0.1)));
        Ok(Zone {
            normal: normal.unwrap_or(plain.normal),
            angle: angle.unwrap_or(plain.angle),
            weight: weight.unwrap_or(plain.weight),
            ..plain
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: DVec3 = DVec3::new(0.01, 0.02, 0.15);

    fn zones() -> [Zone; 3] {
        let zone = |area| Zone { normal: DVec3::new(0.3, -0.2, 1.0), angle: 0.4, ..Zone::new(area, AT) };
        [
            zone(Area::Circle { radius: 0.03 }),
            zone(Area::Rectangle { width: 0.05, height: 0.02 }),
            zone(Area::Polygon { radius: 0.03, sides: 5 }),
        ]
    }

    #[test]
    fn samples_fill_the_zone_and_lie_in_its_plane() {
        const SPACING: f64 = 1e-3;
        let areas = [TAU / 2.0 * 9e-4, 1e-3, 2.5 * 9e-4 * (TAU / 5.0).sin()];
        for (zone, area) in zones().into_iter().zip(areas) {
            let points = zone.points(SPACING);
            let own = points.len() as f64 * SPACING * SPACING;
            // The rest is at the edge.
            assert!((own / area - 1.0).abs() < 0.1, "{zone:?}: {own} of {area}");
            assert!(points.iter().any(|point| point.distance(AT) < 1e-12), "its centre");
            let reach = zone.area.half().length();
            for point in &points {
                assert!((*point - AT).dot(zone.normal).abs() < 1e-12, "{zone:?}: {point}");
                assert!(
                    point.distance(AT) <= reach && point.z >= zone.lowest(DVec3::Z).z - 1e-12,
                    "{zone:?}: {point}"
                );
            }
            let nearest = points[1..].iter().map(|point| point.distance(points[0])).fold(1.0, f64::min);
            assert!(nearest > SPACING * 0.999, "{nearest}");
        }
    }

    #[test]
    fn a_polygon_has_its_first_corner_at_the_top() {
        let area = Area::Polygon { radius: 1.0, sides: 3 };
        for (inside, point) in [
            (true, (0.0, 0.99)),
            (false, (0.0, 1.01)),
            (true, (0.0, -0.49)),
            (false, (0.0, -0.51)),
            (true, (0.85, -0.49)),
            (false, (0.6, 0.3)),
        ] {
            assert_eq!(area.contains(DVec2::from(point)), inside, "{point:?}");
        }
    }

    #[test]
    fn samples_are_limited_and_never_none() {
        for (width, height) in [(1e-9, 1e-9), (1e-9, 100.0), (100.0, 100.0), (0.02, 3.0), (0.3, 0.3)] {
            let zone = Zone::new(Area::Rectangle { width, height }, DVec3::Z * 200.0);
            for spacing in [0.0, 1e-300, 2e-3, 1e300, f64::NAN] {
                let count = zone.points(spacing).len();
                assert!((1..=4096).contains(&count), "{width} x {height} in steps of {spacing}: {count}");
            }
        }
        let wide = Zone::new(Area::Rectangle { width: 1.0, height: 1.0 }, DVec3::Z).points(1e-3);
        assert!(wide.len() > 3000, "as many as there may be: {}", wide.len());
    }
}
