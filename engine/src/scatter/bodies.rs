//! All bodies of a scene: the answer of their surfaces to incident sound, and the sound that they scatter.
//!
//! A body answers what reaches it, which is the incident sound, the sound that the others scatter, and the echo of all
//! from mirrors. With x the answers to the incident sound alone and T those to the sound of given answers, the answers
//! are (1 - T)⁻¹ x: few steps of generalised minimal residuals, and none for one body without mirrors.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DMat3, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::mesh::Mesh;
use crate::scatter::boundary::{BodyError, Boundary, SKIN, TOLERANCE, TooLarge};
use crate::scatter::emission::Emission;
use crate::scatter::gmres::{self, Outcome};
use crate::scatter::patch::{Patch, Sound};
use crate::scatter::rows::{Columns, Rows};
use crate::scatter::sphere::Sphere;
use crate::scene::{Body, BodyKind, Reflector};

/// Edges of triangles in wavelengths, and the number of triangles beyond which they grow, up to a longest.
const EDGE: f64 = 1.0 / 6.0;
const MANY: f64 = 12_000.0;
const LONGEST_EDGE: f64 = 0.3;
/// Bytes of a table.
const MOST_TABLE: usize = 256 << 20;
/// Steps of the bodies' answers to each other, and their residual.
const MOST_ECHOES: usize = 60;
const ECHOED: f64 = 1e-5;

/// The bodies of a scene at one wavenumber.
#[derive(Clone, Debug)]
pub struct Bodies {
    solids: Vec<Solid>,
    mirrors: Vec<Reflector>,
}

/// A body and its place.
#[derive(Clone, Debug)]
struct Solid {
    surface: Surface,
    at: DVec3,
    /// Its own axes as columns.
    axes: DMat3,
    /// m, of the smallest ball about `at` around it.
    reach: f64,
}

/// How the sound at a body's surface is described.
#[derive(Clone, Debug)]
enum Surface {
    /// By the coefficients of the sound that reaches it.
    Series(Sphere),
    /// By pressures at nodes.
    Elements(Arc<Boundary>),
}

/// The sound at the surfaces of all bodies (Pa), one body after the other.
pub type Answer = Vec<Vec<Complex64>>;

/// Incident sound at [`Bodies::points`]: pressures (Pa) and slopes along the normals (Pa/m) of one drive.
#[derive(Clone, Debug, Default)]
pub struct Incident {
    pub pressures: Vec<Complex64>,
    pub slopes: Vec<Complex64>,
}

/// A body's surface with what is on it.
#[derive(Clone, Debug)]
pub struct Skin {
    /// m, in the scene's coordinates.
    pub mesh: Mesh,
    /// Pa, at every vertex.
    pub pressures: Vec<Complex64>,
}

impl Bodies {
    /// The bodies of a scene that are loaded, for a wavenumber (rad/m) and sound from places (m).
    ///
    /// # Errors
    /// A body with more triangles than the memory holds.
    pub fn new(
        bodies: &[Body],
        mirrors: &[Reflector],
        wavenumber: f64,
        sources: &[DVec3],
    ) -> Result<Self, TooLarge> {
        let reach = |body: &Body| -> Result<f64, TooLarge> {
            Ok(match body.kind {
                BodyKind::Sphere => body.radius,
                BodyKind::Capsule | BodyKind::Palm | BodyKind::Hand | BodyKind::Mesh => {
                    boundary(body, wavenumber)?.map_or(0.0, |boundary| reach_of(boundary.mesh()))
                }
            })
        };
        let reaches = bodies.iter().map(reach).collect::<Result<Vec<_>, _>>()?;
        // The nearest source of what reaches a body: an element, another body, or the image of one.
        let nearest = |index: usize| {
            let at = bodies[index].at;
            let of_bodies = bodies.iter().zip(&reaches).enumerate().flat_map(|(other, (body, reach))| {
                let direct = (other != index).then_some(body.at);
                let images = mirrors.iter().map(|mirror| seen(mirror, body.at));
                direct.into_iter().chain(images).map(move |place| at.distance(place) - reach)
            });
            let of_elements = sources.iter().map(|source| at.distance(*source));
            of_bodies.chain(of_elements).fold(f64::INFINITY, f64::min)
        };
        let solids = (0..bodies.len())
            .filter_map(|index| Solid::new(&bodies[index], wavenumber, nearest(index)).transpose());
        Ok(Self { solids: solids.collect::<Result<_, _>>()?, mirrors: mirrors.to_vec() })
    }

    pub fn is_empty(&self) -> bool {
        self.solids.is_empty()
    }

    /// Triangles of all surfaces.
    pub fn triangles(&self) -> usize {
        self.triangles_of_each().sum()
    }

    /// Triangles of every body, of a sphere 0.
    pub fn triangles_of_each(&self) -> impl Iterator<Item = usize> {
        self.solids.iter().map(|solid| match &solid.surface {
            Surface::Series(_) => 0,
            Surface::Elements(boundary) => boundary.mesh().triangles.len(),
        })
    }

    /// The places that the bodies turn about, m.
    pub fn places(&self) -> impl Iterator<Item = DVec3> {
        self.solids.iter().map(|solid| solid.at)
    }

    /// Whether a point (m) is inside a body.
    pub fn contains(&self, at: DVec3) -> bool {
        self.solids.iter().any(|solid| solid.contains(at))
    }

    /// Points (m), those in the skin of a body just outside it.
    pub fn lifted(&self, points: &[DVec3]) -> Vec<DVec3> {
        let lifted = |at: &DVec3| self.solids.iter().fold(*at, |at, solid| solid.lifted(at));
        points.par_iter().map(lifted).collect()
    }

    /// The points (m) at which incident sound is needed, with the normals of the surfaces there.
    pub fn points(&self) -> (Vec<DVec3>, Vec<DVec3>) {
        self.solids.iter().flat_map(Solid::points).unzip()
    }

    /// The answers to incident sounds, from earlier answers if there are any.
    ///
    /// # Panics
    /// Other than a value per point.
    pub fn answers(&self, incident: &[Incident], starts: Option<&[Answer]>) -> Vec<Answer> {
        let alone = self.alone(incident, starts);
        if self.solids.len() < 2 && self.mirrors.is_empty() {
            return alone;
        }
        let flat = |answers: &[Answer]| answers.iter().map(|it| it.concat()).collect::<Vec<_>>();
        let rights = flat(&alone);
        let starts = starts.map(flat);
        let apply = |xs: &[Vec<Complex64>]| {
            let answers: Vec<_> = xs.iter().map(|x| self.parts(x)).collect();
            let echoes: Vec<_> = answers.iter().map(|answer| self.between(answer)).collect();
            let echoes = flat(&self.alone(&echoes, None));
            xs.iter().zip(echoes).map(|(x, t)| x.iter().zip(t).map(|(x, t)| x - t).collect()).collect()
        };
        let limits = (ECHOED, MOST_ECHOES);
        let outcomes = gmres::solve(&rights, starts.as_deref(), limits, apply, <[_]>::to_vec);
        outcomes.iter().map(|outcome| self.parts(&outcome.values)).collect()
    }

    /// The answers of bodies that hear nothing of each other.
    fn alone(&self, incident: &[Incident], starts: Option<&[Answer]>) -> Vec<Answer> {
        let mut answers = vec![Answer::new(); incident.len()];
        let mut first = 0;
        for (index, solid) in self.solids.iter().enumerate() {
            let points = first..first + solid.count();
            let starts =
                starts.map(|starts| starts.iter().map(|answer| answer[index].clone()).collect::<Vec<_>>());
            let own: Vec<_> = match &solid.surface {
                Surface::Series(sphere) => {
                    incident.par_iter().map(|it| sphere.coefficients(&it.pressures[points.clone()])).collect()
                }
                Surface::Elements(boundary) => {
                    let rights: Vec<_> = incident
                        .iter()
                        .map(|it| {
                            boundary.right_side(&it.pressures[points.clone()], &it.slopes[points.clone()])
                        })
                        .collect();
                    let solved = boundary.solve(&rights, starts.as_deref(), TOLERANCE);
                    solved.into_iter().map(|outcome| outcome.values).collect()
                }
            };
            answers.iter_mut().zip(own).for_each(|(answer, own)| answer.push(own));
            first = points.end;
        }
        answers
    }

    /// What reaches every body from the others and by mirrors.
    fn between(&self, answer: &Answer) -> Incident {
        let mut incident = Incident::default();
        for (index, solid) in self.solids.iter().enumerate() {
            let (points, normals): (Vec<_>, Vec<_>) = solid.points().into_iter().unzip();
            let heard = self.heard_by(answer, &points, Some(index), false);
            let slopes = heard.iter().zip(&normals).map(|((_, slope), normal)| along(*slope, *normal));
            incident.slopes.extend(slopes);
            incident.pressures.extend(heard.iter().map(|(p, _)| p));
        }
        incident
    }

    /// Scattered pressures (Pa) and their gradients (Pa/m) at points (m) outside.
    pub fn sounds(&self, answer: &Answer, points: &[DVec3]) -> Vec<Sound> {
        self.heard(answer, points, None)
    }

    /// The same, in f32 far from surfaces.
    pub fn sounds_in_f32(&self, answer: &Answer, points: &[DVec3]) -> Vec<Sound> {
        self.heard_by(answer, points, None, false)
    }

    /// The same without the direct sound of one of them.
    fn heard(&self, answer: &Answer, points: &[DVec3], but: Option<usize>) -> Vec<Sound> {
        self.heard_by(answer, points, but, true)
    }

    fn heard_by(&self, answer: &Answer, points: &[DVec3], but: Option<usize>, double: bool) -> Vec<Sound> {
        let points = &self.lifted(points)[..];
        let mut sums = vec![(Complex64::ZERO, [Complex64::ZERO; 3]); points.len()];
        for (index, (solid, own)) in self.solids.iter().zip(answer).enumerate() {
            if but != Some(index) {
                let direct = solid.sounds(own, points, double);
                sums.iter_mut().zip(direct).for_each(|(sum, own)| add(sum, own, 1.0));
            }
            for mirror in &self.mirrors {
                let normal = mirror.normal.normalize_or_zero();
                let there: Vec<_> = points.iter().map(|at| seen(mirror, *at)).collect();
                for (sum, (p, gradient)) in sums.iter_mut().zip(solid.sounds(own, &there, double)) {
                    let turned = along(gradient, normal) * 2.0;
                    let gradient = [0, 1, 2].map(|axis| gradient[axis] - turned * normal[axis]);
                    add(sum, (p, gradient), mirror.coefficient);
                }
            }
        }
        sums
    }

    /// Scattered pressures (Pa) at points (m) outside, in f32 far from surfaces.
    pub fn pressures(&self, answer: &Answer, points: &[DVec3]) -> Vec<Complex64> {
        let points = &self.lifted(points)[..];
        let mut all = self.corrections(answer, points);
        for emission in self.emissions(answer) {
            let own = emission.pressures(points);
            all.iter_mut().zip(own).for_each(|(sum, p)| *sum += p);
        }
        all
    }

    /// The sources of all surfaces of triangles and of their images.
    pub fn emissions(&self, answer: &Answer) -> Vec<Emission> {
        let of = |(solid, own): (&Solid, &Vec<Complex64>)| {
            let Surface::Elements(boundary) = &solid.surface else { return Vec::new() };
            let emission = boundary.emission(own);
            let direct = emission.placed(solid.axes, solid.at, 1.0);
            let image = |mirror: &Reflector| {
                let normal = mirror.normal.normalize_or_zero();
                let columns = [solid.axes.x_axis, solid.axes.y_axis, solid.axes.z_axis];
                let [x, y, z] = columns.map(|axis| axis - normal * (2.0 * axis.dot(normal)));
                let axes = DMat3::from_cols(x, y, z);
                emission.placed(axes, seen(mirror, solid.at), mirror.coefficient)
            };
            [direct].into_iter().chain(self.mirrors.iter().map(image)).collect()
        };
        self.solids.iter().zip(answer).flat_map(of).collect()
    }

    /// The scattered sound of every element at points (m) outside, from the answers to each; `None` if it is too large.
    pub fn table(&self, columns: &[Answer], points: &[DVec3]) -> Option<Rows> {
        let points = &self.lifted(points)[..];
        let mut table = Rows::zeros(columns.len(), points.len(), MOST_TABLE)?;
        for (index, solid) in self.solids.iter().enumerate() {
            let own: Vec<_> = columns.iter().map(|column| &column[index][..]).collect();
            solid.tabulate(&own, points, 1.0, &mut table);
            for mirror in &self.mirrors {
                let there: Vec<_> = points.iter().map(|at| seen(mirror, *at)).collect();
                solid.tabulate(&own, &there, mirror.coefficient as f32, &mut table);
            }
        }
        Some(table)
    }

    /// What the sums of [`Self::emissions`] lack at points (m): near triangles, and the sound of spheres.
    pub fn corrections(&self, answer: &Answer, points: &[DVec3]) -> Vec<Complex64> {
        let mut all = vec![Complex64::ZERO; points.len()];
        for (solid, own) in self.solids.iter().zip(answer) {
            let direct = solid.corrections(own, points);
            all.iter_mut().zip(direct).for_each(|(sum, p)| *sum += p);
            for mirror in &self.mirrors {
                let there: Vec<_> = points.iter().map(|at| seen(mirror, *at)).collect();
                let echo = solid.corrections(own, &there);
                all.iter_mut().zip(echo).for_each(|(sum, p)| *sum += p * mirror.coefficient);
            }
        }
        all
    }

    /// The weights of an answer, all parts in sequence, in the pressure at a point (m) outside and in its slopes along the
    /// axes.
    pub fn weights(&self, at: DVec3) -> Vec<[Complex64; 4]> {
        let at = self.lifted(&[at])[0];
        let mut all = Vec::new();
        for solid in &self.solids {
            let mut own = solid.weights(at);
            for mirror in &self.mirrors {
                let normal = mirror.normal.normalize_or_zero();
                for (sum, [p, slope @ ..]) in own.iter_mut().zip(solid.weights(seen(mirror, at))) {
                    let turned = along(slope, normal) * 2.0;
                    let slope = [0, 1, 2].map(|axis| slope[axis] - turned * normal[axis]);
                    let echo = [p, slope[0], slope[1], slope[2]];
                    sum.iter_mut().zip(echo).for_each(|(sum, echo)| *sum += echo * mirror.coefficient);
                }
            }
            all.extend(own);
        }
        all
    }

    /// The weights of incident pressures and slopes at [`Self::points`] in what weights of the answer give, by one solution
    /// for each instead of one for each sound; `None` of bodies that hear each other, and of spheres, whose answers cost
    /// little.
    pub fn adjoints(&self, weights: &[Vec<Complex64>]) -> Option<Vec<Incident>> {
        let [Solid { surface: Surface::Elements(boundary), .. }] = &self.solids[..] else { return None };
        let solved = self.mirrors.is_empty().then(|| boundary.solve_transposed(weights, None, TOLERANCE))?;
        let of = |outcome: Outcome| {
            let (pressures, slopes) = boundary.right_side_weights(&outcome.values);
            Incident { pressures, slopes }
        };
        Some(solved.into_iter().map(of).collect())
    }

    /// Bounds on the error of each body's sound, from the incident sound at the surfaces and that (Pa) at any points; spheres
    /// have none.
    pub fn errors(
        &self,
        answer: &Answer,
        incident: &Incident,
        heard: impl Fn(&[DVec3]) -> Vec<Complex64>,
    ) -> Vec<BodyError> {
        let others = (self.solids.len() > 1 || !self.mirrors.is_empty()).then(|| self.between(answer));
        let mut first = 0;
        let mut errors = Vec::new();
        for (index, (solid, own)) in self.solids.iter().zip(answer).enumerate() {
            let points = first..first + solid.count();
            first = points.end;
            let Surface::Elements(boundary) = &solid.surface else {
                errors.push(BodyError { surface: 0.0, outside: 0.0 });
                continue;
            };
            let mut pressures = incident.pressures[points.clone()].to_vec();
            if let Some(others) = &others {
                pressures.iter_mut().zip(&others.pressures[points]).for_each(|(sum, p)| *sum += p);
            }
            let inner: Vec<_> =
                boundary.inner_points().into_iter().map(|at| solid.at + solid.axes * at).collect();
            let mut within = heard(&inner);
            if others.is_some() {
                let heard = self.heard(answer, &inner, Some(index));
                within.iter_mut().zip(heard).for_each(|(sum, (p, _))| *sum += p);
            }
            let outcome = Outcome { values: own.clone(), residual: TOLERANCE, steps: 0 };
            errors.push(boundary.error(&outcome, &pressures, &within));
        }
        errors
    }

    /// The surfaces in small parts, with the total sound on them.
    pub fn patches(&self, answer: &Answer) -> Vec<Vec<Patch>> {
        self.solids.iter().zip(answer).map(|(solid, own)| solid.patches(own)).collect()
    }

    /// The surfaces with their pressures, of spheres with edges of about a length (m).
    pub fn skins(&self, answer: &Answer, edge: f64) -> Vec<Skin> {
        self.solids.iter().zip(answer).map(|(solid, own)| solid.skin(own, edge)).collect()
    }

    fn parts(&self, x: &[Complex64]) -> Answer {
        let mut rest = x;
        let mut part = |solid: &Solid| {
            let (own, others) = rest.split_at(solid.unknowns());
            rest = others;
            own.to_vec()
        };
        self.solids.iter().map(&mut part).collect()
    }
}

impl Solid {
    /// `None` of a mesh that is not loaded, or axes that are none.
    fn new(body: &Body, wavenumber: f64, nearest: f64) -> Result<Option<Self>, TooLarge> {
        let Some(axes) = body.axes() else { return Ok(None) };
        let at = body.at;
        let surface = match body.kind {
            BodyKind::Sphere => {
                let shape = (DVec3::ZERO, body.radius, body.coefficient);
                Surface::Series(Sphere::heard_from(nearest, shape, wavenumber))
            }
            BodyKind::Capsule | BodyKind::Palm | BodyKind::Hand | BodyKind::Mesh => {
                let Some(boundary) = boundary(body, wavenumber)? else { return Ok(None) };
                Surface::Elements(boundary)
            }
        };
        let reach = match &surface {
            Surface::Series(sphere) => sphere.radius(),
            Surface::Elements(boundary) => reach_of(boundary.mesh()),
        };
        Ok(Some(Self { surface, at, axes, reach }))
    }

    fn own(&self, at: DVec3) -> DVec3 {
        self.axes.transpose() * (at - self.at)
    }

    /// The place (m) just outside of a point in the skin.
    fn lifted(&self, at: DVec3) -> DVec3 {
        if at.distance_squared(self.at) >= self.reach * self.reach {
            return at;
        }
        let own = self.own(at);
        match &self.surface {
            Surface::Series(sphere) => {
                let is_in_skin = own.length() < sphere.radius() && own.length() >= sphere.radius() - SKIN;
                if is_in_skin {
                    self.at + (at - self.at).normalize_or(DVec3::Z) * sphere.radius()
                } else {
                    at
                }
            }
            Surface::Elements(boundary) => {
                let lifted = boundary.lifted(own);
                if lifted == own { at } else { self.at + self.axes * lifted }
            }
        }
    }

    fn contains(&self, at: DVec3) -> bool {
        if at.distance_squared(self.at) >= self.reach * self.reach {
            return false;
        }
        let own = self.own(at);
        match &self.surface {
            Surface::Series(sphere) => own.length() < sphere.radius() - SKIN,
            Surface::Elements(boundary) => boundary.contains(own),
        }
    }

    /// Numbers of points and of unknowns.
    fn count(&self) -> usize {
        match &self.surface {
            Surface::Series(sphere) => sphere.points().len(),
            Surface::Elements(boundary) => 3 * boundary.mesh().triangles.len(),
        }
    }

    fn unknowns(&self) -> usize {
        match &self.surface {
            Surface::Series(sphere) => (sphere.order() + 1).pow(2),
            Surface::Elements(boundary) => boundary.mesh().vertices.len(),
        }
    }

    /// Points and normals. A sphere needs no slopes, so its normals are zero.
    fn points(&self) -> Vec<(DVec3, DVec3)> {
        let place = |at: DVec3| self.at + self.axes * at;
        match &self.surface {
            Surface::Series(sphere) => {
                sphere.points().into_iter().map(|at| (place(at), DVec3::ZERO)).collect()
            }
            Surface::Elements(boundary) => {
                let (points, normals) = boundary.points();
                points.into_iter().zip(normals).map(|(at, n)| (place(at), self.axes * n)).collect()
            }
        }
    }

    fn sounds(&self, own: &[Complex64], points: &[DVec3], double: bool) -> Vec<Sound> {
        let points: Vec<_> = points.iter().map(|at| self.own(*at)).collect();
        let sounds: Vec<_> = match &self.surface {
            Surface::Series(sphere) => points.par_iter().map(|at| sphere.scattered(own, *at)).collect(),
            Surface::Elements(boundary) if double => boundary.sound(own, &points),
            Surface::Elements(boundary) => boundary.sounds(own, &points),
        };
        sounds.into_iter().map(|(p, gradient)| (p, self.turned(gradient))).collect()
    }

    /// A gradient in the scene's axes.
    fn turned(&self, gradient: [Complex64; 3]) -> [Complex64; 3] {
        [0, 1, 2].map(|axis| along(gradient, self.axes.row(axis)))
    }

    fn tabulate(&self, columns: &[&[Complex64]], points: &[DVec3], gain: f32, table: &mut Rows) {
        let points: Vec<_> = points.iter().map(|at| self.own(*at)).collect();
        match &self.surface {
            Surface::Series(sphere) => table.each_mut().zip(&points).for_each(|((re, im), at)| {
                let weights = sphere.weights(*at);
                for ((re, im), column) in re.iter_mut().zip(im).zip(columns) {
                    let sum: Complex64 = weights.iter().zip(*column).map(|([w, ..], value)| w * value).sum();
                    *re += gain * sum.re as f32;
                    *im += gain * sum.im as f32;
                }
            }),
            Surface::Elements(boundary) => {
                boundary.tabulate(&Columns::new(columns.iter().copied()), &points, gain, table);
            }
        }
    }

    fn corrections(&self, own: &[Complex64], points: &[DVec3]) -> Vec<Complex64> {
        let points: Vec<_> = points.iter().map(|at| self.own(*at)).collect();
        match &self.surface {
            Surface::Series(sphere) => points.par_iter().map(|at| sphere.scattered(own, *at).0).collect(),
            Surface::Elements(boundary) => {
                boundary.corrections(own, &points).into_iter().map(|(p, _)| p).collect()
            }
        }
    }

    fn weights(&self, at: DVec3) -> Vec<[Complex64; 4]> {
        let weights = match &self.surface {
            Surface::Series(sphere) => sphere.weights(self.own(at)),
            Surface::Elements(boundary) => boundary.weights(self.own(at)),
        };
        let turned = |[p, slope @ ..]: [Complex64; 4]| {
            let [x, y, z] = self.turned(slope);
            [p, x, y, z]
        };
        weights.into_iter().map(turned).collect()
    }

    fn patches(&self, own: &[Complex64]) -> Vec<Patch> {
        let mut patches = match &self.surface {
            Surface::Series(sphere) => sphere.patches(own),
            Surface::Elements(boundary) => boundary.patches(own),
        };
        for Patch { at, normal, sound: (_, gradient), .. } in &mut patches {
            (*at, *normal) = (self.at + self.axes * *at, self.axes * *normal);
            *gradient = self.turned(*gradient);
        }
        patches
    }

    fn skin(&self, own: &[Complex64], edge: f64) -> Skin {
        let (mesh, pressures) = match &self.surface {
            Surface::Series(sphere) => {
                let mesh = crate::mesh::shapes::sphere(sphere.radius(), edge);
                let of = |at: &DVec3| sphere.on_surface(own, at.normalize_or(DVec3::Z));
                let pressures = mesh.vertices.par_iter().map(of).collect();
                (mesh, pressures)
            }
            Surface::Elements(boundary) => (boundary.mesh().clone(), boundary.surface(own)),
        };
        Skin { mesh: mesh.mapped(|at| self.at + self.axes * at), pressures }
    }
}

/// The latest surfaces: bodies that move and turn keep theirs.
static SURFACES: Mutex<Vec<(Body, f64, Arc<Boundary>)>> = Mutex::new(Vec::new());
/// Their number.
const KEPT: usize = 4;

/// The surface of a body in its own coordinates; `None` of a mesh that is not loaded.
fn boundary(body: &Body, wavenumber: f64) -> Result<Option<Arc<Boundary>>, TooLarge> {
    let shape = Body { at: DVec3::ZERO, normal: None, x_axis: DVec3::X, ..body.clone() };
    let lock = || SURFACES.lock().unwrap_or_else(PoisonError::into_inner);
    let kept = lock().iter().find(|(own, k, _)| (own, k) == (&shape, &wavenumber)).map(|it| it.2.clone());
    if kept.is_some() {
        return Ok(kept);
    }
    let wavelength = TAU / wavenumber;
    let Some(mesh) = shape.solid(EDGE * wavelength) else { return Ok(None) };
    let grown = EDGE * (mesh.triangles.len() as f64 / MANY).sqrt();
    let mesh = match grown > EDGE && shape.edge.is_none() {
        true => shape.solid(grown.min(LONGEST_EDGE) * wavelength).unwrap_or(mesh),
        false => mesh,
    };
    let made = Arc::new(Boundary::new(&mesh, shape.coefficient, wavenumber)?);
    let mut all = lock();
    all.truncate(KEPT - 1);
    all.insert(0, (shape, wavenumber, Arc::clone(&made)));
    Ok(Some(made))
}

/// m, of the smallest ball about the origin around a mesh.
fn reach_of(mesh: &Mesh) -> f64 {
    mesh.vertices.iter().map(|at| at.length()).fold(0.0, f64::max)
}

/// The image of a point.
fn seen(mirror: &Reflector, at: DVec3) -> DVec3 {
    at - mirror.normal.normalize_or_zero() * (2.0 * mirror.height(at))
}

fn add(sum: &mut Sound, (p, gradient): Sound, gain: f64) {
    sum.0 += p * gain;
    sum.1.iter_mut().zip(gradient).for_each(|(sum, slope)| *sum += slope * gain);
}

fn along(gradient: [Complex64; 3], direction: DVec3) -> Complex64 {
    gradient[0] * direction.x + gradient[1] * direction.y + gradient[2] * direction.z
}
