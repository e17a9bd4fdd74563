//! A local server for the page.

use std::fs::File;
use std::path::{Component, Path, PathBuf};

use anyhow::anyhow;
use tiny_http::{Header, Request, Response, Server};

/// Serves the files of a folder on 127.0.0.1 until stopped, and prints its address. Port 0 is any free port.
pub fn serve(folder: &Path, port: u16) -> anyhow::Result<()> {
    let server = Server::http(("127.0.0.1", port)).map_err(|error| anyhow!("port {port}: {error}"))?;
    let address = server.server_addr().to_ip().ok_or_else(|| anyhow!("no address"))?;
    println!("http://localhost:{}/", address.port());
    for request in server.incoming_requests() {
        // The client may have disconnected.
        let _ = answer(folder, request);
    }
    Ok(())
}

fn answer(folder: &Path, request: Request) -> std::io::Result<()> {
    let path = request.url().split(['?', '#']).next().unwrap_or_default();
    let Some(path) = within(folder, path) else {
        return request.respond(Response::empty(404));
    };
    let accepted = request.headers().iter().find(|header| header.field.equiv("Accept-Encoding"));
    let accepted = accepted.map(|header| header.value.to_string()).unwrap_or_default();
    let packed = [("br", "br"), ("gzip", "gz")].into_iter().find_map(|(name, ending)| {
        let file = File::open(format!("{}.{ending}", path.display())).ok()?;
        accepted.contains(name).then_some((name, file))
    });
    let Some((encoding, file)) =
        packed.map(|(name, file)| (Some(name), file)).or_else(|| Some((None, File::open(&path).ok()?)))
    else {
        return request.respond(Response::empty(404));
    };
    let mut response = Response::from_file(file);
    for (name, value) in headers(&path).into_iter().chain(encoding.map(|name| ("Content-Encoding", name))) {
        if let Ok(header) = Header::from_bytes(name, value) {
            response.add_header(header);
        }
    }
    request.respond(response)
}

/// The file of an address, within the folder only.
fn within(folder: &Path, address: &str) -> Option<PathBuf> {
    let relative = Path::new(address.trim_start_matches('/'));
    let is_plain = relative.components().all(|part| matches!(part, Component::Normal(_)));
    let path = folder.join(relative);
    let path = if path.is_dir() { path.join("index.html") } else { path };
    (is_plain && path.is_file()).then_some(path)
}

fn headers(path: &Path) -> Vec<(&'static str, &'static str)> {
    let kind = match path.extension().unwrap_or_default().to_string_lossy().as_ref() {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "toml" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    };
    // Cross-origin isolated, and revalidated after a new build.
    vec![
        ("Content-Type", kind),
        ("Cache-Control", "no-cache"),
        ("Cross-Origin-Opener-Policy", "same-origin"),
        ("Cross-Origin-Embedder-Policy", "require-corp"),
    ]
}
