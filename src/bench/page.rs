//! The report as one page of HTML that needs nothing else: figures, conditions, and every section with its charts and tables.

use std::fmt::Write;

use crate::bench::conditions::{Conditions, is_optimised};
use crate::bench::figures::{self, Measured};
use crate::bench::{Report, Section};
use crate::picture::PictureError;
use crate::picture::chart;

/// The file's name in the folder of the plots.
pub const NAME: &str = "report.html";

const STYLE: &str = include_str!("page.css");

/// # Errors
/// A chart without points.
pub fn html(
    conditions: &Conditions,
    sections: &[Section],
    figures: &[Measured],
) -> Result<String, PictureError> {
    let mut body = String::new();
    for section in sections {
        body += &of_section(section)?;
    }
    let links: String = sections
        .iter()
        .map(|section| format!("<a href=\"#{}\">{}</a>\n", section.name, escaped(section.title)))
        .collect();
    let dark = chart::dark_style();
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>Sonoglyph, measured</title>\n<style>\n{STYLE}@media screen and \
         (prefers-color-scheme: dark) {{\n{dark}}}\n</style>\n</head>\n<body>\n<main>\n<h1>Sonoglyph, measured</h1>\n\
         <nav>\n{links}</nav>\n{}{}{body}</main>\n</body>\n</html>\n",
        of_conditions(conditions),
        of_figures(figures),
    ))
}

fn of_conditions(conditions: &Conditions) -> String {
    let mut html = String::from("<dl>\n");
    for (name, text) in conditions.rows() {
        let _ = writeln!(html, "<dt>{name}</dt><dd>{}</dd>", escaped(&text));
    }
    html += "</dl>\n";
    if !is_optimised() {
        html += "<p class=\"warning\">This program was built for debugging: only its errors and counts mean something. Build it \
                 with <code>--release</code>.</p>\n";
    }
    html += "<p>Milliseconds differ between machines, and ratios to the baseline in the same run much less: compare these. The \
             baseline of a map is the same map with every pixel evaluated; of a dent, a picture of the pressure; of a solver, 200 \
             iterations of weighted Gerchberg-Saxton; of a drawing, weighted Gerchberg-Saxton for foci 4 mm apart; of the window, the window with every pixel evaluated; of a link, what the \
             line carries. Works and their baseline take turns, round by round. A ratio is the median over the rounds, with \
             quartiles beside it: half of the rounds lay between them. CPU-ms count all threads of the process, and other work on \
             the machine moves them little.</p>\n";
    html
}

fn of_figures(figures: &[Measured]) -> String {
    if figures.is_empty() {
        return String::new();
    }
    let mut html = format!(
        "<section>\n<h2>The figures of the README</h2>\n<p>They were measured on {}. Figures that this run did not measure are \
         left out.</p>\n<div class=\"table\"><table>\n<thead><tr><th>figure</th><th class=\"n\">this run</th><th \
         class=\"n\">quartiles</th><th class=\"n\">README</th><th class=\"n\">expected</th><th>this run lies</th></tr></thead>\
         \n<tbody>\n",
        figures::MACHINE
    );
    for measured in figures {
        let ([found, quartiles], [stated, spread]) = (measured.found(), measured.figure.stated());
        let verdict =
            if measured.is_within() { "<td>within</td>" } else { "<td class=\"outside\">outside</td>" };
        let name = code(&escaped(measured.figure.name));
        let numbers =
            [found, quartiles, stated, spread].map(|text| format!("<td class=\"n\">{text}</td>")).concat();
        let _ = writeln!(html, "<tr><td>{name}</td>{numbers}{verdict}</tr>");
    }
    html + "</tbody>\n</table></div>\n</section>\n"
}

fn of_section(section: &Section) -> Result<String, PictureError> {
    let mut html = format!("<section id=\"{}\">\n<h2>{}</h2>\n", section.name, escaped(section.title));
    match &section.found {
        Err(reason) => {
            let _ = writeln!(html, "<p class=\"warning\">Not measured: {}.</p>", escaped(reason));
        }
        Ok(report) => {
            for (name, chart) in &report.charts {
                let _ = writeln!(
                    html,
                    "<figure id=\"{name}\">\n<figcaption>{}</figcaption>\n{}</figure>",
                    escaped(&chart.title),
                    chart.svg()?
                );
            }
            for note in &report.notes {
                let _ = writeln!(html, "<p>{}</p>", code(&escaped(note)));
            }
            html += &of_rows(report);
        }
    }
    Ok(html + "</section>\n")
}

fn of_rows(report: &Report) -> String {
    let class = |column: usize| if report.holds_numbers(column) { " class=\"n\"" } else { "" };
    let cells = |tag: &str, texts: &mut dyn Iterator<Item = &str>| {
        let cell =
            |(column, text): (usize, &str)| format!("<{tag}{}>{}</{tag}>", class(column), escaped(text));
        texts.enumerate().map(cell).collect::<String>()
    };
    let head = cells("th", &mut report.header.iter().copied());
    let mut html = format!("<div class=\"table\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n");
    for row in &report.rows {
        let _ = writeln!(html, "<tr>{}</tr>", cells("td", &mut row.iter().map(String::as_str)));
    }
    html + "</tbody>\n</table></div>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What stands between backticks is code.
fn code(text: &str) -> String {
    let part = |(index, part): (usize, &str)| {
        if index % 2 == 1 { format!("<code>{part}</code>") } else { part.to_owned() }
    };
    text.split('`').enumerate().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::json;
    use crate::picture::chart::{Chart, Series};

    fn sections() -> Vec<Section> {
        let chart = Chart {
            title: "Time against error".to_owned(),
            x_label: "error".to_owned(),
            y_label: "ms".to_owned(),
            series: vec![Series {
                name: "cpu".to_owned(),
                points: vec![(1e-6, 90.0), (1e-3, f64::NAN), (1e-2, 2.0)],
            }],
            levels: Vec::new(),
        };
        let found = Report {
            header: vec!["evaluator", "ms"],
            rows: vec![vec!["cpu <of today>".to_owned(), "1.5".to_owned()]],
            notes: vec!["read `ms` & think".to_owned()],
            records: vec![serde_json::json!({
                "what": "nothing happens", "frames": 0, "ms": f64::NAN, "ratio": f64::INFINITY,
            })],
            charts: vec![("field-error".to_owned(), chart)],
        };
        vec![
            Section { name: "window", title: "Frames", found: Ok(found) },
            Section { name: "link", title: "Links", found: Err("there is <no> line".to_owned()) },
        ]
    }

    #[test]
    fn a_page_holds_every_section_and_asks_for_nothing() {
        let (conditions, sections) = (Conditions::now(), sections());
        let html = html(&conditions, &sections, &figures::measured(&json(&conditions, &sections))).unwrap();
        for part in [
            "<h2>Frames</h2>",
            "<figcaption>Time against error</figcaption>\n<svg",
            "cpu &lt;of today&gt;",
            "<td class=\"n\">1.5</td>",
            "<code>ms</code> &amp; think",
            "Not measured: there is &lt;no&gt; line.",
            "a second in which nothing happens",
            "href=\"#link\"",
        ] {
            assert!(html.contains(part), "{part} is missing from {html}");
        }
        for asked in ["src=", "href=\"http", "url(", "@import", "<script", "<link"] {
            assert!(!html.contains(asked), "{asked} asks for something else");
        }
        for tag in ["section", "table", "figure", "div", "p", "tr", "td", "svg", "main", "dl"] {
            let (opened, closed) =
                (html.matches(&format!("<{tag}>")).count(), html.matches(&format!("</{tag}>")).count());
            assert_eq!(opened + html.matches(&format!("<{tag} ")).count(), closed, "<{tag}>");
        }
    }

    #[test]
    fn numbers_that_are_none_leave_the_json_whole() {
        let text = serde_json::to_string(&json(&Conditions::now(), &sections())).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(value["window"][0]["ms"].is_null() && value["window"][0]["ratio"].is_null(), "{value}");
        assert_eq!(value["missing"]["link"], "there is <no> line");
        assert_eq!(value["figures"][0]["within"], true, "{value}");
    }

    #[test]
    fn every_colour_of_a_chart_has_one_for_the_dark_that_it_is_told_by() {
        let svg = sections()[0].found.as_ref().unwrap().charts[0].1.svg().unwrap();
        let dark = chart::dark_style();
        for colour in ["#FFFFFF", "#1E1E22", "#0072B2"] {
            assert!(svg.contains(colour) && dark.contains(colour), "{colour}");
        }
    }
}
