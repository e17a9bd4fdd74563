//! Arrays of Ultraino (`arrays/*.xml.gz`): transducers in a graph of Java beans.
//!
//! Java writes statements that build the graph, and leaves out what equals a default: coordinates 0, and the identity
//! as rotation. An element with `class` makes an object, one with `property` or `method = "getField"` names a part of
//! one, and `idref` repeats one. Ultraino's y points upwards, and a transducer radiates along its own y; its own
//! export turns both as here: (x, -z, y).

use std::collections::HashMap;

use roxmltree::Node;

use crate::echo;
use crate::table::records::Records;

/// Deeper nesting is refused.
const DEEPEST: usize = 200;

/// A value of the graph.
#[derive(Clone, Debug)]
enum Value {
    Nothing,
    Number(f64),
    Text(String),
    /// Index of an object.
    Object(usize),
    /// A part of an object that is set next.
    Part(String),
}

/// An object: its parts by name, and what was added to it.
#[derive(Debug, Default)]
struct Object {
    parts: HashMap<String, Value>,
    items: Vec<usize>,
}

#[derive(Debug, Default)]
struct Graph<'a> {
    objects: Vec<Object>,
    by_id: HashMap<&'a str, usize>,
    transducers: Vec<usize>,
}

/// The transducers of a simulation, in its order.
///
/// # Errors
/// A file without transducers, as a message.
pub(crate) fn table(root: Node<'_, '_>) -> Result<Records, String> {
    let mut graph = Graph::default();
    for statement in root.children().filter(Node::is_element) {
        graph.value(statement, None, 0)?;
    }
    let mut listed = graph.objects.iter().filter_map(|object| match object.parts.get("transducers") {
        Some(&Value::Object(list)) => Some(&graph.objects[list].items),
        Some(Value::Nothing | Value::Number(_) | Value::Text(_) | Value::Part(_)) | None => None,
    });
    let list = listed.find(|list| !list.is_empty()).unwrap_or(&graph.transducers);
    if list.is_empty() {
        return Err("this Ultraino simulation has no transducers".to_owned());
    }
    let row = |&transducer: &usize| {
        let transform = graph.part(Some(transducer), &["transform"]);
        let place = graph.part(transform, &["translation"]);
        let rotation = graph.part(transform, &["rot", "rotation"]);
        let [x, y, z] = ["x", "y", "z"].map(|name| graph.number(place, name, 0.0));
        let [a, b, c, w] = [("x", 0.0), ("y", 0.0), ("z", 0.0), ("w", 1.0)]
            .map(|(name, default)| graph.number(rotation, name, default));
        let [nx, ny, nz] = [2.0 * (a * b - w * c), w * w - a * a + b * b - c * c, 2.0 * (b * c + w * a)];
        (1, [x, -z, y, nx, -nz, ny].iter().map(|number| format!("{number:?}")).collect())
    };
    let names = Some(["x", "y", "z", "nx", "ny", "nz"].map(str::to_owned).to_vec());
    Ok(Records { names, rows: list.iter().map(row).collect(), separator: b',' })
}

impl<'a> Graph<'a> {
    fn add(&mut self) -> usize {
        self.objects.push(Object::default());
        self.objects.len() - 1
    }

    fn part(&self, object: Option<usize>, names: &[&str]) -> Option<usize> {
        let parts = &self.objects[object?].parts;
        names.iter().find_map(|name| match parts.get(*name) {
            Some(Value::Object(part)) => Some(*part),
            Some(Value::Nothing | Value::Number(_) | Value::Text(_) | Value::Part(_)) | None => None,
        })
    }

    fn number(&self, object: Option<usize>, name: &str, default: f64) -> f64 {
        match object.and_then(|object| self.objects[object].parts.get(name)) {
            Some(Value::Number(number)) => *number,
            Some(Value::Nothing | Value::Text(_) | Value::Object(_) | Value::Part(_)) | None => default,
        }
    }

    /// The value of an element, after its statement about `target` and those within it.
    fn value(&mut self, node: Node<'a, '_>, target: Option<&Value>, depth: usize) -> Result<Value, String> {
        if depth > DEEPEST {
            return Err("this Ultraino simulation is nested too deeply".to_owned());
        }
        let text = || node.text().unwrap_or("").trim();
        match node.tag_name().name() {
            "float" | "double" | "int" | "long" | "short" | "byte" => {
                let number =
                    text().parse().map_err(|_| format!("`{}`: not a number", echo::value(text())))?;
                return Ok(Value::Number(number));
            }
            "string" => return Ok(Value::Text(text().to_owned())),
            "object" | "void" => {}
            _ => return Ok(Value::Nothing),
        }
        let class = node.attribute("class");
        let is_static = class.is_some() && node.attribute("method").is_some();
        let mut own = match (node.attribute("idref"), class) {
            (Some(id), _) => Some(self.by_id.get(id).map_or(Value::Nothing, |&object| Value::Object(object))),
            (None, Some(class)) if !is_static => {
                let object = self.add();
                if class.ends_with(".Transducer") {
                    self.transducers.push(object);
                }
                Some(Value::Object(object))
            }
            (None, Some(_) | None) => None,
        };
        self.name(node, own.as_ref());
        let mut arguments = Vec::new();
        for child in node.children().filter(Node::is_element) {
            let is_void = child.tag_name().name() == "void";
            let is_apart = child.attribute("class").is_some() || child.attribute("idref").is_some();
            // Statements within one with a name may refer to it.
            if is_void && own.is_none() && (!is_apart || node.attribute("id").is_some()) {
                own = Some(self.call(node, target, &arguments));
                self.name(node, own.as_ref());
            }
            let value = self.value(child, own.as_ref(), depth + 1)?;
            if !is_void {
                arguments.push(value);
            }
        }
        match own {
            Some(own) => Ok(own),
            None => {
                let own = self.call(node, target, &arguments);
                self.name(node, Some(&own));
                Ok(own)
            }
        }
    }

    fn name(&mut self, node: Node<'a, '_>, value: Option<&Value>) {
        if let (Some(id), Some(Value::Object(object))) = (attribute(node, "id"), value) {
            self.by_id.insert(id, *object);
        }
    }

    /// What a statement makes of its target and arguments.
    fn call(&mut self, node: Node<'a, '_>, target: Option<&Value>, arguments: &[Value]) -> Value {
        match (node.attribute("property"), node.attribute("method"), target, arguments) {
            (Some(name), _, Some(&Value::Object(object)), [value]) => {
                self.objects[object].parts.insert(name.to_owned(), value.clone());
                Value::Nothing
            }
            (Some(name), _, Some(&Value::Object(object)), _) => match self.objects[object].parts.get(name) {
                Some(part) => part.clone(),
                None => {
                    let part = Value::Object(self.add());
                    self.objects[object].parts.insert(name.to_owned(), part.clone());
                    part
                }
            },
            (None, Some("getField"), _, [Value::Text(name), ..]) => Value::Part(name.clone()),
            (None, Some("set"), Some(Value::Part(name)), [.., Value::Object(object), value]) => {
                self.objects[*object].parts.insert(name.clone(), value.clone());
                Value::Nothing
            }
            (None, Some("add"), Some(&Value::Object(list)), [.., Value::Object(item)]) => {
                self.objects[list].items.push(*item);
                Value::Nothing
            }
            (_, _, _, _) => Value::Nothing,
        }
    }
}

/// An attribute that lives as long as the document.
fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attribute_node(name).map(|attribute| attribute.value())
}
