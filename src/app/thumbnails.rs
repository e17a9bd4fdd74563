//! Thumbnails of the examples, made in sequence on a thread on demand.

use std::sync::Arc;

use eframe::egui::{ColorImage, Context, TextureOptions};

use crate::app::errand::{Errand, State};
use crate::app::examples::EXAMPLES;
use crate::field::{Evaluator, Quantity, Request, Stages};
use crate::picture::{ColourMap, Picture};
use crate::solver;
use crate::studio::{map, opening};
use crate::ui::gallery::PIXELS;
use crate::ui::{Shown, Texture};

/// The state of the thumbnails.
#[derive(Debug, Default)]
pub(super) struct Thumbnails {
    errand: Option<(usize, Errand<Picture>)>,
}

impl Thumbnails {
    /// Starts the picture of an example, unless another is being made: the request will be repeated.
    pub(super) fn want(&mut self, index: usize, shown: &Shown, ctx: &Context) {
        if self.errand.is_none() && !shown.thumbnails.contains_key(&index) {
            // Without a thread the card stays without its picture.
            self.errand = Errand::start(ctx, move |_| picture(index)).ok().map(|errand| (index, errand));
        }
    }

    /// Shows finished thumbnails.
    pub(super) fn collect(&mut self, shown: &mut Shown, ctx: &Context) {
        let Some((index, errand)) = self.errand.take() else { return };
        let picture = match errand.state() {
            State::UnderWay => {
                self.errand = Some((index, errand));
                return;
            }
            State::Done(picture) => picture,
            State::Failed => blank(),
        };
        let image =
            Arc::new(ColorImage::from_rgba_unmultiplied([picture.width, picture.height], &picture.rgba));
        let texture = ctx.load_texture(format!("example {index}"), image, TextureOptions::LINEAR);
        shown.thumbnails.insert(index, Texture::InEgui(texture));
        ctx.request_repaint();
    }
}

/// An example's field, on the CPU; a dark picture if there is none.
fn picture(index: usize) -> Picture {
    draw(index).unwrap_or_else(blank)
}

fn blank() -> Picture {
    let (width, height) = PIXELS;
    Picture { width, height, rgba: [24, 24, 30, 255].repeat(width * height) }
}

fn draw(index: usize) -> Option<Picture> {
    let example = EXAMPLES.get(index)?;
    let mut scene = opening::parse(example.text, example.name.as_ref()).ok()?;
    // In the plane's shape, fitted to the card.
    let (width, height) = PIXELS;
    scene.plane.size.x = scene.plane.size.y * width as f64 / height as f64;
    // A first drive suffices for a thumbnail.
    let solution = solver::solve_on(&scene, None).ok()?;
    let quantity = match example.name.split('-').next() {
        Some("water") => Quantity::Depression,
        Some("caustic") => Quantity::Caustic,
        Some(_) | None => Quantity::Rms,
    };
    let request = Request::new(&scene, solution.drives(), quantity, PIXELS);
    let drawn = map::draw(&request, ColourMap::Inferno, &mut Stages::new(Evaluator::Cpu), false).ok()?;
    Some(drawn.picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_example_has_a_picture_of_the_cards_size() {
        for name in ["focus-centre", "water-two-points"] {
            let index = EXAMPLES.iter().position(|example| example.name == name).unwrap();
            let picture = draw(index).unwrap();
            assert_eq!((picture.width, picture.height), PIXELS);
            let colours: std::collections::BTreeSet<_> = picture.rgba.chunks(4).collect();
            assert!(colours.len() > 50, "{name}: {} colours", colours.len());
        }
    }
}
