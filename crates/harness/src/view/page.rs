//! The document: data and scripts in one text that needs nothing else.

use super::ViewData;
use crate::report::escaped;

/// The viewer's style, all of it below `.bv-view`.
const STYLE: &str = include_str!("page/view.css");

/// The viewer's scripts in the order in which they must be read; plain scripts with one scope between them.
const SCRIPTS: [&str; 12] = [
    include_str!("page/math.js"),
    include_str!("page/data.js"),
    include_str!("page/mesh.js"),
    include_str!("page/gl.js"),
    include_str!("page/camera.js"),
    include_str!("page/motion.js"),
    include_str!("page/toolpath.js"),
    include_str!("page/scene.js"),
    include_str!("page/timeline.js"),
    include_str!("page/panel.js"),
    include_str!("page/layout.js"),
    include_str!("page/view.js"),
];

/// A whole page that opens from disk without a network.
pub fn page(data: &ViewData) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{} - bvbench</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>html, body {{ margin: 0; height: 100% }}</style>\n</head>\n\
         <body>\n{}</body>\n</html>\n",
        escaped(&data.title),
        viewer(data, "bv-view bv-whole")
    )
}

/// The viewer as a part of another page: a `div` with its style, data and scripts, as tall as its style says (`--bv-height`).
pub fn fragment(data: &ViewData) -> String {
    viewer(data, "bv-view")
}

fn viewer(data: &ViewData, class: &str) -> String {
    let data = serde_json::to_string(data).expect("numbers, texts and lists are always JSON");
    // In a script element only this can end or confuse it.
    let data = data.replace('<', "\\u003c");
    let scripts = SCRIPTS.map(|script| script.replacen("// @ts-check\n", "", 1)).concat();
    format!(
        "<div class=\"{class}\">\n<style>\n{STYLE}</style>\n<script type=\"application/json\">{data}</script>\n\
         <script>\n(() => {{\n\"use strict\";\n{scripts}\nstart(document.currentScript);\n}})();\n</script>\n</div>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Up;
    use crate::scene::Scene;

    #[test]
    fn the_page_stands_alone_and_no_text_escapes() {
        let mut scene = Scene::find("lathe-toolpost").unwrap();
        scene.title = "</title> & </script><b>".to_owned();
        let page = page(&ViewData::of_scene(&scene, Up::Y));
        assert!(page.contains("<title>&lt;/title&gt; &amp; &lt;/script&gt;&lt;b&gt; - bvbench</title>"));
        // One end for the data and one for the scripts.
        assert_eq!(page.matches("</script>").count(), 2);
        for outside in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!page.contains(outside), "{outside}");
        }
    }
}
