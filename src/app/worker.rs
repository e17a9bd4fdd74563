//! The worker of a page: a second instance of the program in a browser thread. Scenes and results are exchanged as
//! bytes, since the two share no memory.

use std::any::type_name;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;

use glam::DVec3;
use js_sys::{Array, Uint8Array};
use serde::{Deserialize, Serialize};
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::{Closure, JsValue, wasm_bindgen};
use web_sys::{MessageEvent, Worker, WorkerOptions, WorkerType};

use crate::app::job::{CompareMethods, Follow, Job, Solve};
use crate::mesh::Mesh;
use crate::scene::{
    Body, Directivity, DriveFile, DriveTable, Elements, Grey, Pixels, Placed, Reading, Scene, Surface, Wire,
    Wires, file,
};

const SCRIPT: &str = "./worker.js";

/// Receives the bytes of an answer.
type Answered = Box<dyn FnOnce(&[u8])>;

thread_local! {
    static CREW: RefCell<Option<Worker>> = const { RefCell::new(None) };
    /// Receivers of answers, in the order of requests.
    static WAITING: RefCell<VecDeque<Answered>> = const { RefCell::new(VecDeque::new()) };
}

/// Vertices and triangles of a file.
type Triangles = (Vec<DVec3>, Vec<[u32; 3]>);

/// A scene with its loaded files.
#[derive(Serialize, Deserialize)]
struct Parcel {
    text: String,
    /// Pixels of pictures, in their order.
    pixels: Vec<Option<Grey>>,
    elements: Option<Vec<Placed>>,
    wires: Option<(Vec<Option<Wire>>, bool)>,
    directivity: Option<Vec<Reading>>,
    /// Vertices and triangles of the bodies' files, in their order.
    surfaces: Vec<Option<Triangles>>,
    drives: Option<DriveTable>,
}

impl Parcel {
    fn of(scene: &Scene) -> Self {
        let pictures = scene.targets.iter().filter_map(|target| target.shape.picture());
        let pixels = pictures.map(|(_, _, pixels)| pixels.get().cloned());
        let elements = scene.array.placed.get().map(<[_]>::to_vec);
        let wires = scene.wires().and_then(|wires| Some((wires.get()?.to_vec(), wires.repeats)));
        let drives = scene.drive.table().cloned();
        let directivity = scene.array.measured.get().map(|measured| measured.readings.clone());
        let mesh = |body: &Body| body.surface.get().map(|it| (it.vertices.clone(), it.triangles.clone()));
        let surfaces = scene.bodies.iter().map(mesh).collect();
        let pixels = pixels.collect();
        Self { text: file::write(scene), pixels, elements, wires, directivity, surfaces, drives }
    }

    fn scene(self) -> Option<Scene> {
        let mut scene = file::parse(&self.text, Path::new("")).ok()?;
        let mut pixels = self.pixels.into_iter();
        for target in &mut scene.targets {
            if let Some((_, own)) = target.shape.picture_mut() {
                *own = pixels.next()?.map_or_else(Pixels::default, Pixels::new);
            }
        }
        if let Some(elements) = self.elements {
            scene.array.placed = Elements::new(elements, None);
        }
        if let Some((wires, repeats)) = self.wires {
            // Those of the elements' file count only without a table of their own.
            let wires = Wires::new(wires, repeats, None);
            (scene.array.placed.wires, scene.array.wires) = (wires.clone(), wires);
        }
        if let Some(readings) = self.directivity {
            scene.array.measured = Directivity::new(readings, None);
        }
        for (body, mesh) in scene.bodies.iter_mut().zip(self.surfaces) {
            if let Some((vertices, triangles)) = mesh {
                body.surface = Surface::new(Mesh { vertices, triangles }, None);
            }
        }
        if let Some(drives) = self.drives {
            scene.drive = DriveFile::new(std::mem::take(&mut scene.drive.name), drives, None);
        }
        Some(scene)
    }
}

/// Sends a scene to the worker, starting it if necessary. If workers are unavailable, `answered` is dropped.
pub fn ask<J: Job>(scene: &Scene, answered: impl FnOnce(J::Made) + 'static) {
    let Some(task) = postcard::to_allocvec(&Parcel::of(scene)).ok() else { return };
    let decode = move |bytes: &[u8]| {
        // Unreadable answers are ignored.
        let _ = postcard::from_bytes(bytes).map(answered);
    };
    let sent = CREW.with_borrow_mut(|crew| {
        let worker = match crew {
            Some(worker) => worker,
            None => crew.insert(start()?),
        };
        let message = Array::of2(&type_name::<J>().into(), &Uint8Array::from(task.as_slice()));
        worker.post_message(&message)
    });
    if sent.is_ok() {
        WAITING.with_borrow_mut(|waiting| waiting.push_back(Box::new(decode)));
    }
}

fn start() -> Result<Worker, JsValue> {
    let options = WorkerOptions::new();
    options.set_type(WorkerType::Module);
    let worker = Worker::new_with_options(SCRIPT, &options)?;
    let hear = Closure::<dyn FnMut(MessageEvent)>::new(|event: MessageEvent| {
        let bytes = event.data().dyn_into::<Uint8Array>().map(|bytes| bytes.to_vec());
        let answered = WAITING.with_borrow_mut(VecDeque::pop_front);
        if let (Some(answered), Ok(bytes)) = (answered, bytes) {
            answered(&bytes);
        }
    });
    // A panicked worker is replaced at the next request; dropping the receivers informs them.
    let fail = Closure::<dyn FnMut()>::new(|| {
        CREW.take().iter().for_each(Worker::terminate);
        WAITING.with_borrow_mut(VecDeque::clear);
    });
    worker.set_onmessage(Some(hear.as_ref().unchecked_ref()));
    worker.set_onerror(Some(fail.as_ref().unchecked_ref()));
    hear.forget();
    fail.forget();
    // The worker reuses the compiled module.
    worker.post_message(&wasm_bindgen::module())?;
    Ok(worker)
}

/// Processes a request in the worker.
///
/// # Errors
/// An unknown request.
#[wasm_bindgen]
pub fn work(name: &str, task: &[u8]) -> Result<Vec<u8>, JsValue> {
    let parcel: Parcel = postcard::from_bytes(task).map_err(|error| JsValue::from(error.to_string()))?;
    let scene = parcel.scene().ok_or("a scene that is none")?;
    // The page and its worker are one program, so names of types serve.
    let made = if name == type_name::<Solve>() {
        postcard::to_allocvec(&Solve::make(&scene))
    } else if name == type_name::<Follow>() {
        postcard::to_allocvec(&Follow::make(&scene))
    } else {
        postcard::to_allocvec(&CompareMethods::make(&scene))
    };
    made.map_err(|error| JsValue::from(error.to_string()))
}
