//! The bodies in the sound of an array, with their answers to it: kept while bodies and array rest.
//!
//! For one drive the answer is found for its sound; for many drives, once for every element.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{element::Element, face::Face};
use crate::scatter::{Answer, Bodies, Incident, TooLarge};
use crate::scene::{Body, Reflector};

/// The bodies in the sound of an aperture; equal if the bodies are.
#[derive(Clone, Debug, Default)]
pub struct Scattering(Option<Arc<Surroundings>>);

/// Bodies and the array that they hear.
#[derive(Debug)]
struct Surroundings {
    bodies: Vec<Body>,
    element: Element,
    faces: Vec<Face>,
    mirrors: Vec<Reflector>,
    made: OnceLock<Result<Bodies, TooLarge>>,
    /// A⁻¹ B: the answer to every element.
    columns: OnceLock<Vec<Answer>>,
    /// The latest drives, by element, with their answers.
    latest: Mutex<Vec<(Vec<Complex64>, Arc<Answer>)>>,
}

/// Drives whose answers are kept: the frames of most motions.
const DRIVES: usize = 64;
/// Arrays with bodies that are kept.
const KEPT: usize = 4;

static LATEST: Mutex<Vec<Arc<Surroundings>>> = Mutex::new(Vec::new());

impl PartialEq for Scattering {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            (Some(own), Some(others)) => Arc::ptr_eq(own, others) || own.bodies == others.bodies,
            (Some(_), None) | (None, Some(_)) => false,
        }
    }
}

impl Scattering {
    /// Bodies in the sound of an array, between mirrors.
    pub(super) fn new(bodies: &[Body], element: Element, faces: &[Face], mirrors: &[Reflector]) -> Self {
        if bodies.is_empty() {
            return Self::default();
        }
        let is_of = |it: &Arc<Surroundings>| {
            (&it.bodies[..], &it.element, &it.faces[..], &it.mirrors[..])
                == (bodies, &element, faces, mirrors)
        };
        let mut kept = LATEST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = kept.iter().position(is_of) {
            let found = kept.remove(found);
            kept.insert(0, Arc::clone(&found));
            return Self(Some(found));
        }
        let made = Arc::new(Surroundings {
            bodies: bodies.to_vec(),
            element,
            faces: faces.to_vec(),
            mirrors: mirrors.to_vec(),
            made: OnceLock::new(),
            columns: OnceLock::new(),
            latest: Mutex::default(),
        });
        kept.truncate(KEPT - 1);
        kept.insert(0, Arc::clone(&made));
        Self(Some(made))
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// Whether a point (m) is inside a body.
    pub fn contains(&self, at: DVec3) -> bool {
        self.bodies().is_some_and(|bodies| bodies.contains(at))
    }

    /// Bodies that are too large for the memory, if any: these scatter nothing.
    pub fn check(&self) -> Result<(), TooLarge> {
        self.0.as_ref().map_or(Ok(()), |it| it.made().as_ref().map(|_| ()).map_err(|error| *error))
    }

    /// The bodies, unless there are none or the memory holds them not.
    pub fn bodies(&self) -> Option<&Bodies> {
        self.0.as_ref().and_then(|it| it.made().as_ref().ok())
    }

    /// The definitions of the bodies.
    pub fn of(&self) -> &[Body] {
        self.0.as_ref().map_or(&[], |it| &it.bodies)
    }

    /// Whether the answers to all elements are known.
    pub(crate) fn has_columns(&self) -> bool {
        self.0.as_ref().is_some_and(|it| it.columns.get().is_some())
    }

    /// Whether the answers to all elements are there, after which that to a drive is a sum.
    pub(super) fn is_prepared(&self) -> bool {
        let is_ready = |it: &Surroundings| match it.made.get() {
            Some(made) => made.is_err() || self.has_columns(),
            None => false,
        };
        self.0.as_deref().is_none_or(is_ready)
    }

    /// Whether the answer to a drive, a value per element, is there or a sum.
    pub(super) fn knows(&self, drive: &[Complex64]) -> bool {
        let is_kept = |it: &Surroundings| {
            let kept = it.latest.lock().unwrap_or_else(PoisonError::into_inner);
            kept.iter().any(|(other, _)| other == drive)
        };
        self.is_prepared() || self.0.as_deref().is_none_or(is_kept)
    }

    /// The answers to all elements, if they are known.
    pub(super) fn known_columns(&self) -> Option<(&Bodies, &[Answer])> {
        Some((self.bodies()?, self.0.as_ref()?.columns.get()?))
    }

    /// The answers to all elements, found by `find` if nobody did.
    pub(super) fn columns(
        &self,
        find: impl FnOnce(&Bodies) -> Vec<Answer> + Send,
    ) -> Option<(&Bodies, &[Answer])> {
        let (own, bodies) = (self.0.as_ref()?, self.bodies()?);
        Some((bodies, own.columns.get_or_init(|| apart(|| find(bodies)))))
    }

    /// The answer to a drive, a value per element, from the sound that `hear` gives.
    pub(super) fn answer(
        &self,
        drive: Vec<Complex64>,
        hear: impl FnOnce(&Bodies) -> Incident,
    ) -> Option<(&Bodies, Arc<Answer>)> {
        let (own, bodies) = (self.0.as_ref()?, self.bodies()?);
        let lock = || own.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let start = {
            let kept = lock();
            if let Some((_, answer)) = kept.iter().find(|(other, _)| *other == drive) {
                return Some((bodies, Arc::clone(answer)));
            }
            kept.first().map(|(_, answer)| vec![(**answer).clone()])
        };
        let answer = match own.columns.get() {
            Some(columns) => combined(columns, &drive),
            None => bodies.answers(&[hear(bodies)], start.as_deref()).remove(0),
        };
        let answer = Arc::new(answer);
        let mut kept = lock();
        kept.truncate(DRIVES - 1);
        kept.insert(0, (drive, Arc::clone(&answer)));
        Some((bodies, answer))
    }
}

impl Surroundings {
    fn made(&self) -> &Result<Bodies, TooLarge> {
        self.made.get_or_init(|| {
            let own =
                |face: &Face| face.layout.positions.iter().map(|at| face.pose.world(*at)).collect::<Vec<_>>();
            let sources: Vec<_> = self.faces.iter().flat_map(own).collect();
            apart(|| Bodies::new(&self.bodies, &self.mirrors, self.element.wavenumber, &sources))
        })
    }
}

/// The result of work in parallel that other threads wait for, from threads of its own: a thread of the usual ones that
/// waits for a part of it would begin another task meanwhile, which may wait for the same result.
fn apart<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if cfg!(target_arch = "wasm32") {
        return work();
    }
    let Ok(pool) = rayon::ThreadPoolBuilder::new().build() else { return work() };
    std::thread::scope(|scope| match scope.spawn(|| pool.install(work)).join() {
        Ok(result) => result,
        Err(panic) => std::panic::resume_unwind(panic),
    })
}

/// The sum of the answers to all elements, each times its drive.
fn combined(columns: &[Answer], drive: &[Complex64]) -> Answer {
    let zero = |own: &Vec<Complex64>| vec![Complex64::ZERO; own.len()];
    let mut sum: Answer = columns[0].iter().map(zero).collect();
    for (u, column) in drive.iter().zip(columns).filter(|(u, _)| **u != Complex64::ZERO) {
        for (sum, own) in sum.iter_mut().flatten().zip(column.iter().flatten()) {
            *sum += u * own;
        }
    }
    sum
}
