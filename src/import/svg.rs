//! The painted paths of an SVG as polylines. usvg resolves styles, units, transforms and the view box.

use std::collections::BTreeMap;

use glam::DVec2;
use kurbo::{BezPath, PathEl, Point};
use usvg::tiny_skia_path::{self, PathSegment};
use usvg::{Group, Node, Options, Paint, Path, Transform, Tree, roxmltree};

use crate::import::{ImportError, Line};
use crate::scene::check::MOST_LETTERS;

/// Largest deviation from a curve relative to the size of its path: a circle has about 100 vertices.
const FINENESS: f64 = 2e-4;
/// Bytes of stack for elements within elements: usvg goes down 1024 of them.
const STACK: usize = 64 << 20;
/// XML nodes: more is no drawing for an array.
const MOST_NODES: u32 = 500_000;

/// Lines with y upwards, and omissions.
pub fn lines(text: &str) -> Result<(Vec<Line>, Vec<String>), ImportError> {
    let read = || lines_of(text);
    // A page has no threads, and the stack that it was built with.
    if cfg!(target_arch = "wasm32") {
        return read();
    }
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, read);
        let refused = |cause: String| Err(ImportError::Svg(cause));
        match thread.map(std::thread::ScopedJoinHandle::join) {
            Ok(Ok(lines)) => lines,
            Ok(Err(_)) => refused("reading it failed".to_owned()),
            Err(error) => refused(error.to_string()),
        }
    })
}

fn lines_of(text: &str) -> Result<(Vec<Line>, Vec<String>), ImportError> {
    let options =
        roxmltree::ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| ImportError::Svg(error.to_string()))?;
    if let Some(count) = places_of_markers(&document).filter(|&count| count > MOST_NODES as usize) {
        return Err(ImportError::TooDetailed(count));
    }
    let has = |name: &str| document.descendants().any(|node| node.tag_name().name() == name);
    let (has_text, has_image) = (has("text"), has("image"));
    // Files named by a drawing are never opened.
    let resolver = usvg::ImageHrefResolver {
        resolve_data: Box::new(|_, _, _| None),
        resolve_string: Box::new(|_, _| None),
    };
    let options = Options { image_href_resolver: resolver, ..Options::default() };
    let tree =
        Tree::from_xmltree(&document, &options).map_err(|error| ImportError::Svg(error.to_string()))?;
    let mut lines = Vec::new();
    gather(tree.root(), "", &labels(&document), &mut lines);
    if lines.is_empty() {
        return Err(ImportError::NoPaths { has_text });
    }
    let mut remarks = Vec::new();
    if has_text {
        remarks.push("Text was ignored: convert it to paths in the drawing program.".to_owned());
    }
    if has_image {
        remarks.push("Pictures inside the SVG were ignored.".to_owned());
    }
    Ok((lines, remarks))
}

/// Labels of elements, as drawing programs show them, by identifier.
type Labels = BTreeMap<String, String>;

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

/// The paths of a group; those without a name have the group's, which is `name`.
fn gather(group: &Group, name: &str, labels: &Labels, lines: &mut Vec<Line>) {
    let named = |id: &str| match (labels.get(id), id) {
        (Some(label), _) => label.clone(),
        (None, "") => name.to_owned(),
        (None, id) => id.to_owned(),
    };
    for node in group.children() {
        match node {
            Node::Group(group) => gather(group, &named(group.id()), labels, lines),
            Node::Path(path) if path.is_visible() && !is_paper(path) => {
                flatten(path, &named(path.id()), lines);
            }
            _ => {}
        }
    }
}

/// A white ground is no part of the drawing.
fn is_paper(path: &Path) -> bool {
    let is_white = |paint: &Paint| matches!(paint, Paint::Color(colour) if colour.red.min(colour.green).min(colour.blue) > 247);
    path.stroke().is_none() && path.fill().is_some_and(|fill| is_white(fill.paint()))
}

/// The subpaths of a path.
fn flatten(path: &Path, name: &str, lines: &mut Vec<Line>) {
    let name: String = name.chars().filter(|letter| !letter.is_control()).take(MOST_LETTERS).collect();
    let mut line = Line::new(Vec::new(), false);
    let mut end = |line: &mut Line| {
        line.points.dedup();
        if line.closed && line.points.first() == line.points.last() {
            line.points.pop();
        }
        // Two points that close are a line there and back.
        line.closed &= line.points.len() > 2;
        let done = std::mem::replace(line, Line::new(Vec::new(), false));
        if done.points.len() > 1 {
            lines.push(Line { name: name.clone(), ..done });
        }
    };
    let size = path.abs_bounding_box();
    let tolerance = FINENESS * f64::from(size.width().max(size.height())).max(1e-6);
    kurbo::flatten(placed(path), tolerance, |element| match element {
        PathEl::MoveTo(to) => {
            end(&mut line);
            line.points.push(DVec2::new(to.x, to.y));
        }
        PathEl::LineTo(to) => line.points.push(DVec2::new(to.x, to.y)),
        PathEl::ClosePath => {
            let first = line.points.first().copied();
            line.closed = true;
            end(&mut line);
            // A continuation without a move starts at the beginning of the closed part.
            line.points.extend(first);
        }
        // Flat paths have none.
        PathEl::QuadTo(..) | PathEl::CurveTo(..) => {}
    });
    end(&mut line);
}

/// The path in the drawing's coordinates, with y upwards.
fn placed(path: &Path) -> BezPath {
    let Transform { sx, kx, ky, sy, tx, ty } = path.abs_transform();
    let [sx, kx, ky, sy, tx, ty] = [sx, kx, ky, sy, tx, ty].map(f64::from);
    let place = |point: tiny_skia_path::Point| {
        let [x, y] = [point.x, point.y].map(f64::from);
        Point::new(sx * x + kx * y + tx, -(ky * x + sy * y + ty))
    };
    let element = |segment| match segment {
        PathSegment::MoveTo(to) => PathEl::MoveTo(place(to)),
        PathSegment::LineTo(to) => PathEl::LineTo(place(to)),
        PathSegment::QuadTo(a, to) => PathEl::QuadTo(place(a), place(to)),
        PathSegment::CubicTo(a, b, to) => PathEl::CurveTo(place(a), place(b), place(to)),
        PathSegment::Close => PathEl::ClosePath,
    };
    path.data().segments().map(element).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn of(body: &str) -> Vec<Line> {
        let text = format!("<svg xmlns='http://www.w3.org/2000/svg' width='200' height='100'>{body}</svg>");
        lines(&text).unwrap().0
    }

    #[test]
    fn a_circle_keeps_its_radius_and_length() {
        let [circle] = &of("<circle cx='50' cy='40' r='30'/>")[..] else { panic!("one line") };
        assert!(circle.closed);
        for point in &circle.points {
            assert!((point.distance(DVec2::new(50.0, -40.0)) - 30.0).abs() < 0.02, "{point}");
        }
        assert!((circle.length() / (TAU * 30.0) - 1.0).abs() < 1e-3, "{}", circle.length());
    }

    #[test]
    fn transforms_and_the_view_box_hold_and_y_goes_upwards() {
        let body = "<g transform='translate(10 20) scale(2)'><path d='M1 2 L5 2 L5 8' fill='none' stroke='red'/></g>";
        assert_eq!(of(body)[0].points, [(12.0, -24.0), (20.0, -24.0), (20.0, -36.0)].map(DVec2::from));
        let boxed = "<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100' viewBox='10 0 50 50'>\
            <path d='M10 0 H60 V50' fill='none' stroke='black'/></svg>";
        let points = &lines(boxed).unwrap().0[0].points;
        assert_eq!(*points, [(0.0, 0.0), (100.0, 0.0), (100.0, -100.0)].map(DVec2::from));
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
            <path d='M0 0h99v99z' fill='none'/><rect width='200' height='100' fill='white'/>\
            <rect width='10' height='10' display='none'/>");
        assert_eq!(lines.iter().map(|line| line.closed).collect::<Vec<_>>(), [true, false]);
        assert_eq!(lines[0].points.len(), 4);
        assert_eq!(lines[0].length(), 40.0);
        assert!(lines[1].points.iter().any(|p| (p.x - 25.0).abs() < 1.0 && (p.y + 5.0).abs() < 0.1));
    }
}
