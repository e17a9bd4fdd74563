//! Drawings as programs write them, imported and compared with what resvg shows of them.

use glam::DVec2;

use crate::import::join::Trace;
use crate::import::svg;

/// A drawing.
struct Sample {
    name: &'static str,
    /// Width and height of the imported lines, mm.
    size: [f64; 2],
    svg: &'static str,
}

/// mm: largest distance of an edge that resvg shows from a line, and of a line from such an edge.
const TOLERANCE: f64 = 0.3;
/// Pixels of resvg's picture per mm.
const DENSITY: f64 = 10.0;
/// mm around the page.
const MARGIN: f64 = 2.0;
/// Pixels of an SVG per mm.
const PIXELS: f64 = 96.0 / 25.4;
/// Smallest difference of colours at an edge, of 255.
const CONTRAST: f64 = 24.0;

const SAMPLES: &[Sample] = &[
    Sample {
        name: "Inkscape: layer, label, mm and a view box",
        size: [40.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
            width="80mm" height="60mm" viewBox="0 0 80 60"><g inkscape:groupmode="layer" inkscape:label="Cut" id="layer1"
            transform="translate(0,-10)"><rect style="fill:none;stroke:#000000;stroke-width:0.264583" id="rect1"
            width="40" height="20" x="20" y="30"/></g></svg>"##,
    },
    Sample {
        name: "Inkscape: clones and a hidden layer",
        size: [50.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="80mm"
            height="60mm" viewBox="0 0 80 60"><g style="display:none"><rect width="80" height="9"/></g>
            <circle id="c" cx="10" cy="30" r="5" style="fill:#d40000"/><use xlink:href="#c" transform="translate(20)"/>
            <use xlink:href="#c" x="40"/></svg>"##,
    },
    Sample {
        name: "Inkscape: clip by a path with a hole",
        size: [40.0, 40.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><defs>
            <clipPath id="a"><path clip-rule="evenodd" d="M10 10h40v40h-40zM20 20h20v20h-20z"/></clipPath></defs>
            <g clip-path="url(#a)"><rect width="60" height="60" fill="#0055d4"/></g></svg>"##,
    },
    Sample {
        name: "Inkscape: opacity of groups",
        size: [20.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60">
            <g opacity="0"><rect width="50" height="50"/></g><g opacity=".5"><rect x="5" y="5" width="20" height="20"
            fill-opacity=".6"/></g></svg>"##,
    },
    Sample {
        name: "Inkscape: dashes",
        size: [50.0, 0.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="20mm" viewBox="0 0 60 20">
            <path d="M5 10H55" style="fill:none;stroke:#000;stroke-width:1;stroke-dasharray:6,5"/></svg>"##,
    },
    Sample {
        name: "Illustrator: entities, points and a switch",
        size: [30.0, 20.0],
        svg: r##"<?xml version="1.0" encoding="utf-8"?><!-- Generator: Adobe Illustrator 24.0 -->
            <!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
            <!ENTITY ns_svg "http://www.w3.org/2000/svg">]><svg version="1.1" id="Ebene_1" xmlns="&ns_svg;" x="0px"
            y="0px" width="50mm" height="40mm" viewBox="0 0 141.732 113.386"><switch><foreignObject
            requiredExtensions="urn:none" width="1" height="1"/><g><polygon fill="#E30613"
            points="14.173,14.173 99.213,14.173 99.213,70.866"/></g></switch></svg>"##,
    },
    Sample {
        name: "Illustrator: styles in a sheet",
        size: [20.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40"><style
            type="text/css">.st0{fill:none;stroke:#1D1D1B;stroke-width:0.5;} .st1{display:none;}</style>
            <circle class="st0" cx="20" cy="20" r="10"/><rect class="st1" width="60" height="40"/></svg>"##,
    },
    Sample {
        name: "Illustrator: white art on a black artboard",
        size: [20.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
            <rect width="40" height="40"/><path style="fill:#FFFFFF" d="M10 30h20L20 10z"/></svg>"##,
    },
    Sample {
        name: "Illustrator: a symbol with a clip",
        size: [10.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40"><symbol id="s"
            viewBox="0 0 10 10"><circle cx="10" cy="10" r="10" fill="#36a9e1"/></symbol>
            <use href="#s" x="5" y="5" width="10" height="10"/></svg>"##,
    },
    Sample {
        name: "Illustrator: overlapping parts of one colour",
        size: [30.0, 30.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
            <g fill="#222"><rect x="5" y="15" width="30" height="10"/><rect x="15" y="5" width="10" height="30"/></g></svg>"##,
    },
    Sample {
        name: "CorelDRAW: hundredths of mm and escaped names",
        size: [30.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" xml:space="preserve" width="40mm" height="20mm" version="1.1"
            style="shape-rendering:geometricPrecision; fill-rule:evenodd" viewBox="0 0 4000 2000"><defs><style
            type="text/css"><![CDATA[.str0 {stroke:#2B2A29;stroke-width:20} .fil0 {fill:none}]]></style></defs>
            <g id="Ebene_x0020_1"><metadata id="CorelCorpID_0Corel-Layer"/><polygon class="fil0 str0"
            points="500,500 3500,500 3500,1500"/></g></svg>"##,
    },
    Sample {
        name: "CorelDRAW: a hairline of no width",
        size: [10.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20"><path d="M0 0H40"
            stroke="#000" stroke-width="0"/><rect x="5" y="5" width="10" height="10" fill="#e31e24"/></svg>"##,
    },
    Sample {
        name: "CorelDRAW: inches",
        size: [25.4, 12.7],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="2in" height="1in" viewBox="0 0 2000 1000"><path
            d="M500 250h1000v500h-1000z" fill="none" stroke="#1F1A17" stroke-width="7"/></svg>"##,
    },
    Sample {
        name: "Affinity: serif namespace and matrices",
        size: [20.0, 20.0],
        svg: r##"<svg width="100%" height="100%" viewBox="0 0 227 227" version="1.1" xmlns="http://www.w3.org/2000/svg"
            xmlns:serif="http://www.serif.com/" style="fill-rule:evenodd;clip-rule:evenodd;stroke-miterlimit:2;"><g
            transform="matrix(1,0,0,1,-100,-50)"><g id="Layer1" serif:id="Layer 1"><path
            d="M120,70L195.590551,70L195.590551,145.590551L120,145.590551Z"
            style="fill:rgb(0,122,255);"/></g></g></svg>"##,
    },
    Sample {
        name: "Affinity: a clipped layer",
        size: [20.0, 20.0],
        svg: r##"<svg width="60mm" height="60mm" viewBox="0 0 60 60" xmlns="http://www.w3.org/2000/svg"><clipPath
            id="_clip1"><rect x="10" y="10" width="20" height="20"/></clipPath><g clip-path="url(#_clip1)"><circle
            cx="20" cy="20" r="13" style="fill:#2b8a3e"/></g></svg>"##,
    },
    Sample {
        name: "Figma: frame with ground and clip",
        size: [10.0, 10.0],
        svg: r##"<svg width="151.181102" height="151.181102" viewBox="0 0 40 40" fill="none"
            xmlns="http://www.w3.org/2000/svg"><g clip-path="url(#clip0)"><rect width="40" height="40" fill="#1E1E1E"/>
            <rect x="15" y="15" width="10" height="10" rx="2" fill="white"/></g><defs><clipPath id="clip0"><rect
            width="40" height="40" fill="white"/></clipPath></defs></svg>"##,
    },
    Sample {
        name: "Figma: inner stroke by a mask",
        size: [20.0, 20.0],
        svg: r##"<svg width="40mm" height="40mm" viewBox="0 0 40 40" fill="none" xmlns="http://www.w3.org/2000/svg">
            <mask id="a" fill="white"><path d="M10 10H30V30H10V10Z"/></mask><path d="M10 10H30V30H10V10Z" fill="#F24E1E"
            mask="url(#a)"/></svg>"##,
    },
    Sample {
        name: "Figma: half a ring by a luminance mask",
        size: [10.0, 20.0],
        svg: r##"<svg width="40mm" height="40mm" viewBox="0 0 40 40" fill="none" xmlns="http://www.w3.org/2000/svg">
            <mask id="m" style="mask-type:luminance" maskUnits="userSpaceOnUse" x="0" y="0" width="40" height="40">
            <rect width="40" height="40" fill="black"/><rect width="20" height="40" fill="white"/></mask>
            <g mask="url(#m)"><circle cx="20" cy="20" r="10" stroke="black" stroke-width=".5"/></g></svg>"##,
    },
    Sample {
        name: "Figma: a gradient and a faint shadow",
        size: [20.0, 10.0],
        svg: r##"<svg width="40mm" height="40mm" viewBox="0 0 40 40" fill="none" xmlns="http://www.w3.org/2000/svg">
            <rect x="10" y="10" width="20" height="10" fill="url(#g)"/><rect x="10" y="25" width="20" height="10"
            fill="black" fill-opacity="0.01"/><defs><linearGradient id="g" x1="10" y1="10" x2="30" y2="10"
            gradientUnits="userSpaceOnUse"><stop stop-color="#0D99FF"/><stop offset="1" stop-color="#9747FF"/>
            </linearGradient></defs></svg>"##,
    },
    Sample {
        name: "Slides: a transparent page rectangle",
        size: [10.0, 5.0],
        svg: r##"<svg version="1.1" viewBox="0.0 0.0 377.952756 188.976378" fill="none" stroke="none"
            stroke-linecap="square" stroke-miterlimit="10" xmlns="http://www.w3.org/2000/svg"><clipPath id="p.0"><path
            d="m0 0l377.952756 0l0 188.976378l-377.952756 0l0 -188.976378z"/></clipPath><g clip-path="url(#p.0)"><path
            fill="#000000" fill-opacity="0.0" d="m0 0l377.952756 0l0 188.976378l-377.952756 0z"/><path fill="#cfe2f3"
            d="m100 50l37.7952756 0l0 18.8976378l-37.7952756 0z"/><path stroke="#595959" stroke-width="1.0"
            d="m100 50l37.7952756 0l0 18.8976378l-37.7952756 0z"/></g></svg>"##,
    },
    Sample {
        name: "PowerPoint: a box in front of a line",
        size: [60.0, 20.0],
        svg: r##"<svg width="80mm" height="40mm" viewBox="0 0 80 40" xmlns="http://www.w3.org/2000/svg"><rect width="80"
            height="40" fill="#FFFFFF"/><path d="M10 20H70" stroke="#4472C4" stroke-width=".5"/><rect x="30" y="10"
            width="20" height="20" fill="#ED7D31" stroke="#2F528F" stroke-width=".3"/></svg>"##,
    },
    Sample {
        name: "Keynote: white lines on a gradient",
        size: [40.0, 10.0],
        svg: r##"<svg width="80mm" height="40mm" viewBox="0 0 80 40" xmlns="http://www.w3.org/2000/svg"><linearGradient
            id="g" x2="0" y2="1"><stop stop-color="#001030"/><stop offset="1" stop-color="#204080"/></linearGradient>
            <rect width="80" height="40" fill="url(#g)"/><path d="M20 15h40v10" fill="none" stroke="#fff"/></svg>"##,
    },
    Sample {
        name: "LaserGRBL: hairlines in colours",
        size: [50.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40"><g
            fill="none" stroke-width=".1"><path stroke="#f00" d="M5 5h50v20h-50z"/><path stroke="#00f"
            d="M10 10h10M10 15h10"/></g></svg>"##,
    },
    Sample {
        name: "CAD: segments of an arc, y upwards",
        size: [20.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40"><g
            transform="matrix(1 0 0 -1 0 40)" stroke="#000" stroke-width=".25"><line x1="10" y1="10" x2="30" y2="10"/>
            <line x1="30" y1="10" x2="30" y2="30"/><line x1="10" y1="30" x2="30" y2="30"/><line x1="10" y1="30" x2="10"
            y2="10"/></g></svg>"##,
    },
    Sample {
        name: "CAD: centimetres and an offset view box",
        size: [30.0, 30.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="5cm" height="5cm" viewBox="-25 -25 50 50"><circle r="15"
            fill="none" stroke="#000" stroke-width="0.18"/></svg>"##,
    },
    Sample {
        name: "CAD: what lies beside the page",
        size: [40.0, 40.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><rect x="10"
            y="10" width="40" height="40" fill="none" stroke="black"/><path d="M400 10l20 0l0 20" fill="none"
            stroke="black"/></svg>"##,
    },
    Sample {
        name: "CAD: over the border of the page",
        size: [20.0, 40.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><circle cx="60"
            cy="30" r="20" fill="#456"/></svg>"##,
    },
    Sample {
        name: "matplotlib: patches, clip and ticks",
        size: [40.0, 30.0],
        svg: r##"<svg xmlns:xlink="http://www.w3.org/1999/xlink" width="170.07874pt" height="127.559055pt"
            viewBox="0 0 170.07874 127.559055" xmlns="http://www.w3.org/2000/svg"><defs><style type="text/css">*{
            stroke-linejoin: round; stroke-linecap: butt}</style></defs><g id="figure_1"><g id="patch_1"><path
            d="M 0 127.559055 L 170.07874 127.559055 L 170.07874 0 L 0 0 z" style="fill: #ffffff"/></g><g id="axes_1">
            <g id="line2d_1"><path d="M 28.346457 200 L 85.03937 -50 L 141.732283 70" clip-path="url(#pab)"
            style="fill: none; stroke: #1f77b4; stroke-width: 1.5"/></g><g id="patch_3"><path
            d="M 28.346457 106.299213 L 28.346457 21.259843 L 141.732283 21.259843 L 141.732283 106.299213 z"
            style="fill: none; stroke: #000000; stroke-width: 0.8"/></g></g></g><defs><clipPath id="pab"><rect
            x="28.346457" y="21.259843" width="113.385827" height="85.03937"/></clipPath></defs></svg>"##,
    },
    Sample {
        name: "matplotlib: markers by use",
        size: [32.0, 12.0],
        svg: r##"<svg xmlns:xlink="http://www.w3.org/1999/xlink" width="60mm" height="40mm" viewBox="0 0 60 40"
            xmlns="http://www.w3.org/2000/svg"><defs><path id="m" d="M0 1C.6 1 1 .6 1 0C1 -.6 .6 -1 0 -1C-.6 -1 -1 -.6 -1
            0C-1 .6 -.6 1 0 1z"/></defs><use xlink:href="#m" x="10" y="10" style="fill:#ff7f0e"/><use xlink:href="#m"
            x="40" y="20" style="fill:#ff7f0e"/></svg>"##,
    },
    Sample {
        name: "vpype: layers of polylines",
        size: [40.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
            baseProfile="tiny" height="5.0cm" version="1.2" viewBox="0 0 188.97638 188.97638" width="5.0cm"><g fill="none"
            id="layer1" inkscape:groupmode="layer" inkscape:label="1" stroke="#00f" style="display:inline"><polyline
            points="18.897638,18.897638 170.078740,18.897638 170.078740,94.488189"/></g></svg>"##,
    },
    Sample {
        name: "draw.io: boxes, an arrow and a label",
        size: [50.5, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" style="background-color: rgb(255, 255, 255);" version="1.1"
            width="70mm" height="30mm" viewBox="-0.5 -0.5 70 30"><defs/><g><rect x="5" y="5" width="20" height="10"
            fill="#ffffff" stroke="#000000" stroke-width=".5" pointer-events="all"/><path d="M 25 10 L 52.5 10"
            fill="none" stroke="#000000" stroke-width=".5" stroke-miterlimit="10"/><path d="M 55.5 10 L 51.5 12 L 52.5 10
            L 51.5 8 Z" fill="#000000" stroke="none"/><g transform="translate(-0.5 -0.5)"><switch><foreignObject
            width="100%" height="100%" requiredFeatures="http://www.w3.org/TR/SVG11/feature#Extensibility"/></switch>
            </g></g></svg>"##,
    },
    Sample {
        name: "draw.io: a box that covers its connector",
        size: [40.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="30mm" viewBox="0 0 60 30"><path
            d="M10 10H50" stroke="#000" stroke-width=".4"/><ellipse cx="30" cy="10" rx="10" ry="5" fill="#fff"
            stroke="#000" stroke-width=".4"/></svg>"##,
    },
    Sample {
        name: "markers at the ends of a line",
        size: [40.0, 6.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="30mm" viewBox="0 0 60 30"><marker id="a"
            viewBox="0 0 6 6" refX="6" refY="3" markerWidth="6" markerHeight="6" orient="auto"><path
            d="M0 0L6 3L0 6z"/></marker><path d="M10 15H50" fill="none" stroke="#000" marker-end="url(#a)"/></svg>"##,
    },
    Sample {
        name: "a nested drawing with its own view box",
        size: [20.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="30mm" viewBox="0 0 60 30"><svg x="10" y="5"
            width="20" height="20" viewBox="0 0 10 10"><path d="M0 0H10V5H0z" fill="#090"/><path d="M0 8H30v9z"
            fill="none" stroke="none"/></svg></svg>"##,
    },
    Sample {
        name: "a picture with a different aspect than its view box",
        size: [30.0, 30.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="30mm" viewBox="0 0 10 10"><path
            d="M0 0H10V10H0z" fill="#903"/></svg>"##,
    },
    Sample {
        name: "a stretched view box",
        size: [60.0, 15.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="30mm" viewBox="0 0 10 10"
            preserveAspectRatio="none"><path d="M0 0H10L5 5z" fill="#903"/></svg>"##,
    },
    Sample {
        name: "picas and points",
        size: [25.4, 12.7],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="18pc" height="144pt" viewBox="0 0 216 144"><path
            d="M36 36h72v36h-72z" fill="#903"/></svg>"##,
    },
    Sample {
        name: "pixels without a view box",
        size: [25.4, 25.4],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200"><circle cx="100" cy="100"
            r="48"/></svg>"##,
    },
    Sample {
        name: "a hole and an island",
        size: [40.0, 40.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><path
            fill-rule="evenodd" d="M10 10h40v40h-40z M15 15h30v30h-30z M25 25h10v10h-10z"/></svg>"##,
    },
    Sample {
        name: "colours that meet at a border",
        size: [40.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><rect x="10"
            y="10" width="20" height="20" fill="#c00"/><rect x="30" y="10" width="20" height="20" fill="#06c"/></svg>"##,
    },
    Sample {
        name: "light art without a ground",
        size: [20.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><circle cx="30"
            cy="30" r="10" fill="#fff"/></svg>"##,
    },
    Sample {
        name: "multiplied colours",
        size: [20.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><circle cx="30"
            cy="30" r="10" fill="#c33"/><rect width="60" height="35" fill="#fff" style="mix-blend-mode:multiply"/></svg>"##,
    },
    Sample {
        name: "a pattern of bars in a disc",
        size: [20.0, 18.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><pattern id="p"
            width="4" height="4" patternUnits="userSpaceOnUse"><rect width="4" height="2" fill="#063"/></pattern>
            <circle cx="30" cy="30" r="10" fill="url(#p)"/></svg>"##,
    },
    Sample {
        name: "a clip in the box of its object",
        size: [10.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><clipPath id="c"
            clipPathUnits="objectBoundingBox"><rect width=".5" height="1"/></clipPath><circle cx="30" cy="30" r="10"
            clip-path="url(#c)"/></svg>"##,
    },
    Sample {
        name: "a filled and stroked disc in a clip",
        size: [12.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><clipPath
            id="c"><rect width="32" height="60"/></clipPath><circle cx="30" cy="30" r="10" fill="#fc6" stroke="#000"
            stroke-width=".2" clip-path="url(#c)"/></svg>"##,
    },
    Sample {
        name: "an open path that is filled",
        size: [30.0, 20.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><path
            d="M10 10H40V30" fill="#960" stroke="#000" stroke-width=".4"/></svg>"##,
    },
    Sample {
        name: "hidden and collapsed parts",
        size: [10.0, 10.0],
        svg: r##"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><g
            visibility="hidden"><rect width="50" height="50"/><rect visibility="visible" x="5" y="5" width="10"
            height="10"/></g></svg>"##,
    },
];

/// The distance from every pixel to the nearest of a set, in pixels (chamfers of 1 and 1.41).
fn distances(set: &[bool], width: usize) -> Vec<f32> {
    let mut distances: Vec<f32> = set.iter().map(|is| if *is { 0.0 } else { f32::INFINITY }).collect();
    let height = set.len() / width;
    let steps: [(isize, f32); 4] =
        [(1, 1.0), (width as isize, 1.0), (width as isize + 1, 1.41), (width as isize - 1, 1.41)];
    let inner = || (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x));
    let mut nearer = |i: usize, sign: isize| {
        for (step, length) in steps {
            let other = distances[i.wrapping_add_signed(sign * step)] + length;
            distances[i] = distances[i].min(other);
        }
    };
    inner().for_each(|i| nearer(i, -1));
    inner().rev().for_each(|i| nearer(i, 1));
    distances
}

/// What resvg shows: its edges, with the width of the picture.
fn edges(svg: &str, is_white: bool) -> (Vec<bool>, usize) {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).unwrap();
    let scale = DENSITY / PIXELS;
    let margin = (MARGIN * DENSITY) as usize;
    let size = DVec2::new(tree.size().width().into(), tree.size().height().into()) * scale;
    let (width, height) = (size.x.round() as usize, size.y.round() as usize);
    let mut page = tiny_skia::Pixmap::new(width as u32, height as u32).unwrap();
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale as f32, scale as f32), &mut page.as_mut());
    let paper = if is_white { 0.0 } else { 255.0 };
    let over = |pixel: &tiny_skia::PremultipliedColorU8| {
        let through = paper * (1.0 - f64::from(pixel.alpha()) / 255.0);
        [pixel.red(), pixel.green(), pixel.blue()].map(|part| f64::from(part) + through)
    };
    let pixels: Vec<_> = page.pixels().iter().map(over).collect();
    // A page that is painted at all its corners goes on around itself.
    let corners = [0, width - 1, width * (height - 1), width * height - 1].map(|i| page.pixels()[i].alpha());
    let is_painted = corners.iter().all(|alpha| *alpha == 255);
    let around = width + 2 * margin;
    let colour = |i: usize| {
        let (x, y) = (i % around, i / around);
        let inside = (margin..margin + width).contains(&x) && (margin..margin + height).contains(&y);
        match inside {
            false if !is_painted => [paper; 3],
            _ => {
                let clamp = |at: usize, size: usize| at.clamp(margin, margin + size - 1) - margin;
                pixels[clamp(y, height) * width + clamp(x, width)]
            }
        }
    };
    let differ = |a: usize, b: usize| {
        colour(a).iter().zip(colour(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > CONTRAST
    };
    let count = around * (height + 2 * margin);
    let is_edge = |i: usize| {
        let is_inner = i > around && i + around + 1 < count;
        is_inner && (differ(i - 1, i + 1) || differ(i - around, i + around))
    };
    ((0..count).map(is_edge).collect(), around)
}

/// Pixels that lines touch.
fn touched(traces: &[Trace], width: usize, count: usize) -> Vec<bool> {
    let mut set = vec![false; count];
    for [a, b] in traces.iter().flat_map(|trace| trace.line.pieces()) {
        let steps = (a.distance(b) / PIXELS * DENSITY * 2.0).ceil().max(1.0) as usize;
        for i in 0..=steps {
            let at = a.lerp(b, i as f64 / steps as f64) / PIXELS + MARGIN;
            let at = (at * DENSITY).max(DVec2::ZERO);
            let index = at.y as usize * width + (at.x as usize).min(width - 1);
            set[index.min(count - 1)] = true;
        }
    }
    set
}

/// The widest stroke of a drawing, mm.
fn widest(group: &usvg::Group) -> f64 {
    let width = |node: &usvg::Node| match node {
        usvg::Node::Group(group) => widest(group),
        usvg::Node::Path(path) => path.stroke().map_or(0.0, |stroke| {
            let transform = path.abs_transform();
            let magnification = (transform.sx * transform.sy - transform.kx * transform.ky).abs().sqrt();
            f64::from(stroke.width().get() * magnification) / PIXELS
        }),
        usvg::Node::Image(_) | usvg::Node::Text(_) => 0.0,
    };
    group.children().iter().map(width).fold(0.0, f64::max)
}

#[test]
fn drawings_are_imported_as_resvg_shows_them() {
    let mut failures = Vec::new();
    for Sample { name, size, svg } in SAMPLES {
        let (traces, remarks) = svg::seen(svg).unwrap_or_else(|error| panic!("{name}: {error}"));
        let points = || traces.iter().flat_map(|trace| trace.line.points.iter().copied());
        let (low, high) = (points().reduce(DVec2::min).unwrap(), points().reduce(DVec2::max).unwrap());
        let found = (high - low) / PIXELS;
        if (found - DVec2::from(*size)).abs().max_element() > 0.02 {
            failures.push(format!("{name}: {found} mm instead of {size:?}"));
        }
        let is_white = remarks.iter().any(|remark| remark.contains("black paper"));
        let (edges, width) = edges(svg, is_white);
        let lines = touched(&traces, width, edges.len());
        let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).unwrap();
        let reach = ((TOLERANCE + widest(tree.root()) / 2.0) * DENSITY) as f32 + 1.0;
        let farthest = |from: &[bool], to: &[bool]| {
            let distances = distances(to, width);
            let far = from.iter().zip(&distances).enumerate().filter(|(_, (is, far))| **is && **far > reach);
            far.map(|(i, _)| DVec2::new((i % width) as f64, (i / width) as f64) / DENSITY - MARGIN).next()
        };
        if let Some(at) = farthest(&lines, &edges) {
            failures.push(format!("{name}: a line at {at} mm is not seen"));
        }
        if let Some(at) = farthest(&edges, &lines) {
            failures.push(format!("{name}: what is seen at {at} mm is not imported"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(SAMPLES.len() > 40);
}
