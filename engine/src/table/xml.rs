//! Arrays in XML: acoular's `MicArray`, and Ultraino's simulations.

use roxmltree::{Document, Node, ParsingOptions};

use crate::echo;
use crate::table::records::Records;
use crate::table::ultraino;

/// Limit of nodes: a file of megabytes may have millions.
const MOST_NODES: u32 = 5_000_000;

/// The places that an XML file has.
///
/// # Errors
/// Line and reason, which names the format.
pub(crate) fn table(text: &str) -> Result<Records, (u64, String)> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        (u64::from(error.pos().row).max(1), format!("broken XML: {}", echo::value(&error.to_string())))
    })?;
    let root = document.root_element();
    match root.tag_name().name() {
        "MicArray" => acoular(root),
        "java" => ultraino::table(root).map_err(|reason| (1, reason)),
        "svg" => Err((1, "this is an SVG drawing: import it as targets".to_owned())),
        "VTKFile" => Err((1, "this is a VTK file: write its points as CSV".to_owned())),
        "COLLADA" => Err((1, "this is a COLLADA model: write its vertices as CSV".to_owned())),
        name => Err((
            1,
            format!(
                "this is XML of `{}`: acoular's MicArray and Ultraino's simulations are read, and CSV",
                echo::value(name)
            ),
        )),
    }
}

/// `<pos Name="Point 1" x="0" y="0" z="0"/>`, m.
fn acoular(root: Node<'_, '_>) -> Result<Records, (u64, String)> {
    let place = |node: Node<'_, '_>| {
        let line = u64::from(node.document().text_pos_at(node.range().start).row);
        let field = |name: &str| {
            let value = node.attribute(name).map(str::to_owned);
            value.ok_or_else(|| (line, format!("acoular's `pos` has no `{name}`")))
        };
        Ok((line, vec![field("x")?, field("y")?, field("z")?]))
    };
    let places = root.descendants().filter(|node| node.tag_name().name() == "pos").map(place);
    let names = Some(["x", "y", "z"].map(str::to_owned).to_vec());
    let rows: Vec<_> = places.collect::<Result<_, _>>()?;
    if rows.is_empty() {
        return Err((1, "acoular's MicArray has no `pos`".to_owned()));
    }
    Ok(Records { names, rows, separator: b',' })
}
