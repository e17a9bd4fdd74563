//! The seen paths of an SVG as polylines. usvg resolves styles, units, transforms, copies and the view box.

use glam::DVec2;
use usvg::{Options, Tree, roxmltree};

use crate::import::area::Bounds;
use crate::import::drawing::{Drawing, ImportError};
use crate::import::join::{Trace, joined};
use crate::import::layers::{self, Fineness, Labels, Omissions};
use crate::import::sight::{self, Paper};

/// Largest deviation from a curve relative to the size of the drawing, and in pixels: 0.04 mm.
const FINENESS: f64 = 1e-4;
const COARSEST: f64 = 0.15;
/// Largest distance of ends that touch, likewise: 0.05 mm.
const TOUCH: f64 = 5e-4;
const WIDEST_TOUCH: f64 = 0.19;
/// The same for ends where a line is hidden, in pixels of the picture that tells what is seen.
const CUT: f64 = 4.0;
/// m, a pixel of an SVG: 1/96 inch.
const PIXEL: f64 = 0.0254 / 96.0;
/// Bytes of stack for elements within elements: usvg goes down 1024 of them.
const STACK: usize = 64 << 20;
/// XML nodes: more is no drawing for an array.
const MOST_NODES: u32 = 500_000;
/// Texts that a remark quotes, and letters of each.
const QUOTED: usize = 3;
const LETTERS: usize = 24;

/// The drawing of an SVG.
pub fn drawing(text: &str) -> Result<Drawing, ImportError> {
    let read = || drawing_of(text);
    // A page has no threads, and the stack that it was built with.
    if cfg!(target_arch = "wasm32") {
        return read();
    }
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, read);
        let refused = |cause: String| Err(ImportError::Svg(cause));
        match thread.map(std::thread::ScopedJoinHandle::join) {
            Ok(Ok(drawing)) => drawing,
            Ok(Err(_)) => refused("reading it failed".to_owned()),
            Err(error) => refused(error.to_string()),
        }
    })
}

fn drawing_of(text: &str) -> Result<Drawing, ImportError> {
    let (mut traces, remarks) = seen(text)?;
    for trace in &mut traces {
        trace.line.points.iter_mut().for_each(|point| point.y = -point.y);
    }
    Drawing::of_unit(traces.into_iter().map(|trace| trace.line).collect(), remarks, Some(PIXEL))
}

/// The seen lines in pixels, y downwards from the top of the page, and omissions.
pub fn seen(text: &str) -> Result<(Vec<Trace>, Vec<String>), ImportError> {
    let options =
        roxmltree::ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| ImportError::Svg(error.to_string()))?;
    if let Some(count) = places_of_markers(&document).filter(|&count| count > MOST_NODES as usize) {
        return Err(ImportError::TooDetailed(count));
    }
    // Files named by a drawing are never opened.
    let resolver = usvg::ImageHrefResolver {
        resolve_data: Box::new(|_, _, _| None),
        resolve_string: Box::new(|_, _| None),
    };
    let options = Options { image_href_resolver: resolver, ..Options::default() };
    let tree =
        Tree::from_xmltree(&document, &options).map_err(|error| ImportError::Svg(error.to_string()))?;
    let mut remarks = ignored(&document);
    let has_text = document.descendants().any(|node| node.tag_name().name() == "text");
    let traces = traces(&tree, &labels(&document), has_text, &mut remarks)?;
    Ok((traces, remarks))
}

fn traces(
    tree: &Tree,
    labels: &Labels,
    has_text: bool,
    remarks: &mut Vec<String>,
) -> Result<Vec<Trace>, ImportError> {
    let size = tree.size();
    let mut page = Bounds { low: DVec2::ZERO, high: DVec2::new(size.width().into(), size.height().into()) };
    let content = tree.root().abs_stroke_bounding_box();
    let corner = |x: f32, y: f32| DVec2::new(x.into(), y.into());
    let content = Bounds {
        low: corner(content.left(), content.top()),
        high: corner(content.right(), content.bottom()),
    };
    let fineness = |page: Bounds| {
        let drawn = content.common(page).unwrap_or(content);
        let pixel = sight::pixel(drawn).max(f64::MIN_POSITIVE);
        let side = drawn.size().max_element();
        let tolerance = (FINENESS * side).clamp(1e-9, COARSEST);
        (Fineness { tolerance, broad: sight::BROAD * pixel }, pixel, (TOUCH * side).min(WIDEST_TOUCH))
    };
    let too_many = || ImportError::Svg("too many paths, copies of patterns, clip paths and masks".to_owned());
    let (fine, mut pixel, mut touch) = fineness(page);
    let (mut shapes, mut left) = layers::shapes(tree.root(), page, labels, fine).ok_or_else(too_many)?;
    if shapes.is_empty() && left.outside > 0 {
        remarks.push("The drawing lies beside its page: it was imported nevertheless.".to_owned());
        page = content.grown(0.01 * content.size().max_element());
        let (fine, smaller, closer) = fineness(page);
        (pixel, touch) = (smaller, closer);
        (shapes, left) = layers::shapes(tree.root(), page, labels, fine).ok_or_else(too_many)?;
    }
    let mut seen = sight::seen(&shapes, page, pixel, Paper::White);
    if seen.traces.is_empty() && seen.hidden > 0 {
        seen = sight::seen(&shapes, page, pixel, Paper::Black);
        if !seen.traces.is_empty() {
            remarks.push("The drawing is white: it is taken as on black paper.".to_owned());
        }
    }
    if seen.traces.is_empty() {
        return Err(nothing(left, seen.hidden, has_text));
    }
    remarks.extend(omitted(left, seen.hidden));
    Ok(joined(seen.traces, touch, CUT * pixel))
}

fn nothing(left: Omissions, hidden: usize, has_text: bool) -> ImportError {
    let reasons = [
        (hidden, "covered or of the colour of its ground"),
        (left.cut, "cut away by clip paths or masks"),
        (left.invisible, "transparent or hidden"),
    ];
    let reasons: Vec<_> =
        reasons.into_iter().filter(|(count, _)| *count > 0).map(|(_, reason)| reason).collect();
    if reasons.is_empty() || has_text {
        return ImportError::NoPaths { has_text };
    }
    ImportError::Unseen(format!("all of it is {}", reasons.join(", or ")))
}

/// A sentence for each kind of omission.
fn omitted(left: Omissions, hidden: usize) -> Vec<String> {
    let count = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(format!("One {one} was left out.")),
        _ => Some(format!("{count} {many} were left out.")),
    };
    let mut remarks: Vec<_> = [
        count(left.outside, "shape beside the page", "shapes beside the page"),
        count(left.cut, "shape outside its clip path or mask", "shapes outside their clip paths or masks"),
        count(left.invisible, "transparent or hidden shape", "transparent or hidden shapes"),
        count(
            hidden,
            "line that is covered or has the colour of its ground",
            "lines that are covered or have the colour of their ground",
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    if left.filters > 0 {
        remarks.push("Filters, such as shadows, were ignored.".to_owned());
    }
    if left.dashed > 0 {
        remarks.push("Lines with very many dashes were imported whole.".to_owned());
    }
    if left.patterns > 0 {
        remarks.push("Very fine patterns were ignored: their shapes have outlines.".to_owned());
    }
    remarks
}

/// Remarks on elements that are not read.
fn ignored(document: &roxmltree::Document<'_>) -> Vec<String> {
    let named =
        |name: &'static str| document.descendants().filter(move |node| node.tag_name().name() == name);
    let mut remarks = Vec::new();
    let words = |node: roxmltree::Node<'_, '_>| {
        let parts: String =
            node.descendants().filter(|node| node.is_text()).filter_map(|node| node.text()).collect();
        let words = parts.split_whitespace().collect::<Vec<_>>().join(" ");
        (!words.is_empty())
            .then(|| words.chars().filter(|letter| !letter.is_control()).take(LETTERS).collect())
    };
    if named("text").next().is_some() {
        let quoted: Vec<String> = named("text").filter_map(words).take(QUOTED).collect();
        let quoted =
            if quoted.is_empty() { String::new() } else { format!(" (\"{}\")", quoted.join("\", \"")) };
        remarks.push(format!("Text was ignored{quoted}: convert it to paths in the drawing program."));
    }
    if named("image").next().is_some() {
        remarks.push("Pictures inside the SVG were ignored.".to_owned());
    }
    let refers = |node: roxmltree::Node<'_, '_>| {
        let links = node.attributes().filter(|attribute| attribute.name() == "href");
        links.map(|link| link.value().trim()).any(|link| !link.starts_with('#'))
    };
    if named("use").any(refers) {
        remarks.push("Parts of other files were ignored.".to_owned());
    }
    remarks
}

fn labels(document: &roxmltree::Document<'_>) -> Labels {
    const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
    let label = |node: roxmltree::Node<'_, '_>| {
        Some((node.attribute("id")?.to_owned(), node.attribute((INKSCAPE, "label"))?.to_owned()))
    };
    document.descendants().filter_map(label).collect()
}

/// Number of nodes if markers are drawn at every vertex: usvg creates them individually.
fn places_of_markers(document: &roxmltree::Document<'_>) -> Option<usize> {
    let nodes = || document.descendants();
    let is_asked_for = |text: &str| text.contains("marker-mid") || text.contains("marker:");
    let asks = |node: roxmltree::Node<'_, '_>| {
        let sheet = node.text().filter(|_| node.tag_name().name() == "style");
        let styles = [node.attribute("style"), sheet];
        ["marker", "marker-mid"].into_iter().any(|name| node.has_attribute(name))
            || styles.into_iter().flatten().any(is_asked_for)
    };
    // A vertex needs at least two bytes.
    let vertices = |node: roxmltree::Node<'_, '_>| {
        node.attribute("d").or(node.attribute("points")).map_or(0, |text| text.len() / 2)
    };
    let marked = nodes().filter(|node| node.tag_name().name() == "marker");
    let marks: usize = marked.map(|node| node.descendants().count()).sum();
    nodes().any(asks).then(|| nodes().map(vertices).sum::<usize>().saturating_mul(marks))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::import::Line;

    fn lines(text: &str) -> Result<Vec<Line>, ImportError> {
        Ok(seen(text)?.0.into_iter().map(|trace| trace.line).collect())
    }

    fn of(body: &str) -> Vec<Line> {
        lines(&format!("<svg xmlns='http://www.w3.org/2000/svg' width='200' height='100'>{body}</svg>"))
            .unwrap()
    }

    fn is_at(points: &[DVec2], wanted: &[(f64, f64)]) {
        assert_eq!(points.len(), wanted.len(), "{points:?}");
        for (point, &wanted) in points.iter().zip(wanted) {
            assert!(point.distance(DVec2::from(wanted)) < 1e-3, "{point} {wanted:?}");
        }
    }

    #[test]
    fn a_circle_keeps_its_radius_and_length() {
        let [circle] = &of("<circle cx='50' cy='40' r='30'/>")[..] else { panic!("one line") };
        assert!(circle.closed);
        for point in &circle.points {
            assert!((point.distance(DVec2::new(50.0, 40.0)) - 30.0).abs() < 0.02, "{point}");
        }
        assert!((circle.length() / (TAU * 30.0) - 1.0).abs() < 1e-3, "{}", circle.length());
    }

    #[test]
    fn transforms_and_the_view_box_hold_and_y_goes_upwards() {
        let body = "<g transform='translate(10 20) scale(2)'><path d='M1 2 L5 2 L5 8' fill='none' stroke='red'/></g>";
        is_at(&of(body)[0].points, &[(12.0, 24.0), (20.0, 24.0), (20.0, 36.0)]);
        let boxed = "<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100' viewBox='10 0 50 50'>\
            <path d='M10 0 H60 V50' fill='none' stroke='black'/></svg>";
        is_at(&lines(boxed).unwrap()[0].points, &[(0.0, 0.0), (100.0, 0.0), (100.0, 100.0)]);
        is_at(&drawing(boxed).unwrap().lines[0].points, &[(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]);
    }

    #[test]
    fn markers_at_every_vertex_are_counted_before_they_are_made() {
        let marked = |nodes: usize, vertices: usize, asks: &str| {
            let (marks, path) = ("<path d='M0 0L2 2'/>".repeat(nodes), "L1 2".repeat(vertices));
            lines(&format!(
                "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'><marker id='m'>{marks}</marker>\
                 <path {asks} stroke='red' d='M0 0{path}'/></svg>"
            ))
        };
        for asks in ["marker-mid='url(#m)'", "style='marker:url(#m)'"] {
            assert!(matches!(marked(300, 20_000, asks), Err(ImportError::TooDetailed(_))), "{asks}");
            assert!(marked(2, 100, asks).is_ok(), "{asks}");
        }
        assert!(marked(300, 20_000, "").is_ok(), "nobody asks for them");
    }

    #[test]
    fn subpaths_are_lines_of_their_own_and_what_is_not_painted_is_none() {
        let lines = of("<path d='M0 0h10v10h-10z M20 0 q5 10 10 0 l3 0' stroke='black' fill='none'/>\
            <path d='M0 0h99v99z' fill='none'/><rect width='10' height='10' display='none'/>");
        assert_eq!(lines.iter().map(|line| line.closed).collect::<Vec<_>>(), [true, false]);
        assert_eq!(lines[0].points.len(), 4);
        assert!((lines[0].length() - 40.0).abs() < 1e-3);
        assert!(lines[1].points.iter().any(|p| (p.x - 25.0).abs() < 1.0 && (p.y - 5.0).abs() < 0.1));
    }

    #[test]
    fn omissions_are_said_and_an_unseen_drawing_is_refused_with_its_reason() {
        let svg = |body: &str| {
            drawing(&format!("<svg xmlns='http://www.w3.org/2000/svg' width='90' height='90'>{body}</svg>"))
        };
        let remarks = svg(
            "<circle cx='40' cy='40' r='9'/><text x='9'>Lid\n A</text><rect x='200' width='5' height='5'/>\
            <rect width='9' height='9' opacity='0'/><circle cx='40' cy='40' r='5'/><image/><use href='a.svg#b'/>",
        );
        let remarks = remarks.unwrap().remarks.join("\n");
        for part in ["(\"Lid A\")", "Pictures", "other files", "beside the page", "transparent", "covered"] {
            assert!(remarks.contains(part), "{part}: {remarks}");
        }
        let refusals = [
            ("<rect width='9' height='9' opacity='0'/>", "transparent or hidden"),
            (
                "<clipPath id='c'><rect width='1' height='1'/></clipPath><g clip-path='url(#c)'><path d='M5 5h9v9'/></g>",
                "cut away",
            ),
            ("<text>A</text>", "convert its text"),
        ];
        for (body, reason) in refusals {
            let error = svg(body).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
        let beside = svg("<path d='M-50 -50h20v20z'/>").unwrap();
        assert_eq!((beside.lines.len(), beside.remarks.len()), (1, 1), "{beside:?}");
    }

    #[test]
    fn names_and_groups_are_those_of_the_drawing() {
        let text = "<svg xmlns='http://www.w3.org/2000/svg' width='90' height='90' \
            xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape'><g id='Teil_x0020_A'><rect width='9' height='9' \
            x='5' y='5'/></g><g id='g1' inkscape:label='Lid'><g id='g2'><circle id='c' cx='50' cy='50' r='9'/></g></g></svg>";
        let lines = lines(text).unwrap();
        let names: Vec<_> = lines.iter().map(|line| (line.name.as_str(), line.group.as_str())).collect();
        assert_eq!(names, [("Teil A", "Teil A"), ("c", "Lid")]);
    }
}
