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
    let text = root.document().input_text().as_bytes();
    let (mut start, mut line) = (0, 1);
    let place = |node: Node<'_, '_>| {
        // Counting from the last place on, since there may be many.
        line += text[start..node.range().start].iter().filter(|&&byte| byte == b'\n').count() as u64;
        start = node.range().start;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two transducers with parts left out, as Java writes them.
    const SIMULATION: &str = r#"<java class="java.beans.XMLDecoder">
        <object class="acousticfield3d.simulation.Simulation" id="Simulation0"/>
        <void class="acousticfield3d.math.Vector3f" method="getField"><string>x</string><void method="set">
          <void class="acousticfield3d.simulation.Transducer" id="Transducer0">
            <void property="orderNumber"><int>1</int></void>
            <void id="Transform0" property="transform">
              <void property="rot">
                <void property="w"><float>0.70710678</float></void>
                <void property="x"><float>0.70710678</float></void>
              </void>
              <void id="Vector3f2" property="scale"/>
              <void id="Vector3f3" property="translation">
                <void class="acousticfield3d.math.Vector3f" method="getField"><string>y</string>
                  <void method="set"><object idref="Vector3f3"/><float>0.02</float></void></void>
                <void class="acousticfield3d.math.Vector3f" method="getField"><string>z</string>
                  <void method="set"><object idref="Vector3f3"/><float>0.03</float></void></void>
              </void>
            </void>
          </void>
          <void idref="Transform0"/><object idref="Vector3f2"/><float>0.01</float>
        </void></void>
        <void class="acousticfield3d.simulation.Transducer" id="Transducer1">
          <void property="transform"><void id="V4" property="translation">
            <void property="x"><float>-0.01</float></void></void></void>
        </void>
        <void class="acousticfield3d.simulation.Simulation" method="getField"><string>transducers</string>
          <void method="set"><object idref="Simulation0"/>
            <object class="java.util.ArrayList" id="ArrayList0">
              <void method="add"><object idref="Transducer1"/></void>
              <void method="add"><object idref="Transducer0"/></void>
            </object></void></void>
        </java>"#;

    #[test]
    fn transducers_are_in_the_simulations_order_with_z_upwards() {
        let rows = table(SIMULATION).unwrap().rows;
        let numbers: Vec<Vec<f64>> =
            rows.iter().map(|(_, row)| row.iter().map(|field| field.parse().unwrap()).collect()).collect();
        assert_eq!(numbers[0], [-0.01, 0.0, 0.0, 0.0, 0.0, 1.0]);
        // A quarter turn about x points y to z, which is -y here.
        for (found, expected) in numbers[1].iter().zip([0.0, -0.03, 0.02, 0.0, -1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-7, "{numbers:?}");
        }
        let none = r#"<java><object class="acousticfield3d.simulation.Simulation" id="S"/></java>"#;
        assert!(table(none).unwrap_err().1.contains("Ultraino simulation has no transducers"));
    }
}
