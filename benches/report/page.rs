//! The report as one self-contained HTML page: conditions, README figures, and sections with charts and tables.

use minijinja::value::Serde;
use minijinja::{Environment, Value};
use serde_json::json;
use sonoglyph::picture::chart;

use crate::{Section, figures};

/// # Errors
/// A chart without points, or a run that does not fit the template.
pub fn html(run: &serde_json::Value, sections: &[Section]) -> anyhow::Result<String> {
    let sections = sections.iter().map(of_section).collect::<anyhow::Result<Vec<_>>>()?;
    let readme = std::fs::read_to_string(figures::README).unwrap_or_default();
    let mut measured = Vec::new();
    for figure in figures::all()? {
        if let Some(found) = figure.found(run) {
            measured.push(json!({
                "name": figure.name,
                "found": figure.text(found.median),
                "quartiles": figure.range(found.quartiles),
                "stated": figure.stated(&readme),
                "expected": figure.expected(),
                "is_expected": figure.is_expected(found.median),
            }));
        }
    }
    let mut environment = Environment::new();
    environment.add_filter("code", |escaped: String| Value::from_safe_string(code(&escaped)));
    environment.add_template("page.html", include_str!("page.html"))?;
    let page = json!({ "run": run, "sections": sections, "figures": measured, "dark": chart::dark_style() });
    Ok(environment.get_template("page.html")?.render(Serde(page))?)
}

fn of_section(section: &Section) -> anyhow::Result<serde_json::Value> {
    let mut value = json!({ "name": section.subject.name(), "title": section.subject.title() });
    match &section.found {
        Err(reason) => value["missing"] = json!(reason),
        Ok(report) => {
            let chart = |(name, chart): &(String, chart::Chart)| {
                Ok(json!({ "name": name, "title": chart.title, "svg": chart.svg()? }))
            };
            value["charts"] = report.charts.iter().map(chart).collect::<anyhow::Result<_>>()?;
            value["notes"] = json!(report.notes);
            value["header"] = json!(report.header);
            value["rows"] = json!(report.rows);
            let classes =
                (0..report.header.len()).map(|column| if report.holds_numbers(column) { "n" } else { "" });
            value["classes"] = classes.collect();
        }
    }
    Ok(value)
}

/// Marks text between backticks as code.
fn code(text: &str) -> String {
    let part = |(index, part): (usize, &str)| {
        if index % 2 == 1 { format!("<code>{part}</code>") } else { part.to_owned() }
    };
    text.split('`').enumerate().map(part).collect()
}
