//! Two needles that cross nearly along each other, through the whole program: no method misses a contact, none makes one up.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use std::fmt::Write;
use support::{Folder, words};

/// Needles of 208 mm, 5e-4 mm wide, mm. A triangle test in plain `f64` misses 355 of the 375 contacts below.
const NEEDLES: [(&str, [[f64; 3]; 3]); 2] = [
    (
        "a",
        [
            [-34.274252116680145, -47.27775298058987, 89.74991941452026],
            [63.30316865444183, -212.95781388878822, 125.95042143762112],
            [-12.492192193865776, -84.26226216554642, 97.83090268075466],
        ],
    ),
    (
        "b",
        [
            [-21.929138243198395, -68.23886640369892, 94.32958959043026],
            [75.64826188981533, -233.91887848079205, 130.53037072718143],
            [-21.9295651614666, -68.23905102908611, 94.32989537715912],
        ],
    ),
];

const SCENE: &str = r#"
title = "two needles"
pairs = [["a", "b"]]
recorded = { file = "poses.csv" }

parts = [
  { name = "a", mesh = "a.obj" },
  { name = "b", mesh = "b.obj" },
]
"#;

/// Shifts of the second needle by 1e-8 to 1e-4 mm in directions spread over the sphere.
fn poses() -> String {
    let mut csv = "part,qw,qx,qy,qz,tx,ty,tz\n".to_owned();
    for i in 0..400 {
        let turn = f64::from(i) * 2.399_963_229_728_653;
        let z = 1.0 - (f64::from(i) + 0.5) / 200.0;
        let (flat, size) = ((1.0 - z * z).sqrt(), 10f64.powf(-8.0 + 4.0 * f64::from(i % 40) / 40.0));
        let [x, y, z] = [flat * turn.cos(), flat * turn.sin(), z].map(|x| x * size);
        writeln!(csv, "b,1,0,0,0,{x:e},{y:e},{z:e}").unwrap();
    }
    csv
}

#[test]
fn crossing_needles_hide_no_contact_from_any_safe_method() {
    let folder = Folder::with(&[("needles/scene.toml", SCENE), ("needles/poses.csv", &poses())]);
    for (name, corners) in NEEDLES {
        let vertices = corners.map(|[x, y, z]| format!("v {x:?} {y:?} {z:?}\n")).concat();
        folder.write(&format!("needles/{name}.obj"), &format!("{vertices}f 1 2 3\n"));
    }
    let variants =
        ["obb-area", "aabb", "sphere-ritter", "dop-14", "rss", "triangle-octree", "uniform-grid", "obb-wide"];
    let plan = "stage verify --profile smoke --scene needles --workload recorded --out run --quiet";
    let mut arguments = words(plan);
    for variant in variants {
        arguments.extend(["--variant", variant]);
    }
    folder.done(&arguments);
    let mut reader = csv::Reader::from_path(folder.path("run/verification.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let mut seen = std::collections::BTreeMap::new();
    for record in reader.records() {
        let record = record.unwrap();
        let cell = |name: &str| &record[headers.iter().position(|header| header == name).unwrap()];
        let number = |name: &str| cell(name).parse::<u64>().unwrap();
        assert_eq!((number("missed"), number("false_positives"), number("missed_by_leaf")), (0, 0, 0), "{record:?}");
        if cell("band") != "grazing" {
            *seen
                .entry((cell("variant").to_owned(), cell("split").to_owned(), cell("split_axes").to_owned()))
                .or_insert(0) += number("exact");
        }
    }
    assert!(seen.len() >= variants.len(), "{seen:?}");
    assert!(seen.values().all(|&contacts| contacts > 200), "{seen:?}");
}
