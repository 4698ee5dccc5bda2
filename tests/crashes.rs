//! Planted crashes on six small machines, each found at its line with its parts and nothing else told, and good programs that are clear.
//!
//! The cases are a table: what is planted, on which machine, the program, and all that `check` has to say. [`table`] writes it as
//! `docs/crashes.md`, which a test holds against the file; `BVBENCH_WRITE_DOCS=1` writes the file.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use bvbench::scene::Scene;
use std::fmt::Write as _;
use std::path::Path;
use support::{in_memory, run_own, with_zones};

/// The machines: name and scene.
const MACHINES: [(&str, &str); 6] = [
    ("mill", include_str!("crashes/mill.toml")),
    ("trunnion", include_str!("crashes/trunnion.toml")),
    ("fork", include_str!("crashes/fork.toml")),
    ("horizontal", include_str!("crashes/horizontal.toml")),
    ("lathe", include_str!("crashes/lathe.toml")),
    ("press", include_str!("crashes/press.toml")),
];

/// What is told: line, kind, and parts or axis.
type Told = (u32, &'static str, &'static str);

/// A program with a fault.
struct Crash {
    machine: &'static str,
    fault: &'static str,
    /// What is otherwise in the scene: a text and what replaces it.
    change: Option<(&'static str, &'static str)>,
    program: &'static str,
    told: &'static [Told],
}

/// A program without one.
struct Good {
    machine: &'static str,
    work: &'static str,
    /// As of [`Crash`].
    change: Option<(&'static str, &'static str)>,
    program: &'static str,
}

const COLLISION: &str = "collision";
const RAPID: &str = "rapid-into-workpiece";
const STOPPED: &str = "stopped-spindle-into-workpiece";
const CHANGE: &str = "tool-change-into-workpiece";
const TRAVEL: &str = "over-travel";
const UNRESOLVED: &str = "unresolved";

const fn crash(machine: &'static str, fault: &'static str, program: &'static str, told: &'static [Told]) -> Crash {
    Crash { machine, fault, change: None, program, told }
}

const fn good(machine: &'static str, work: &'static str, program: &'static str) -> Good {
    Good { machine, work, change: None, program }
}

/// The drill of the mill as an engraving cutter: a ball of 0.2 mm, 0.4 mm of it cut, on a cone.
const ENGRAVER: (&str, &str) = (
    "shape = { kind = \"cylinder\", radius_mm = 4, height_mm = 90 }",
    "shape = { kind = \"revolve\", profile_mm = [[0, 0], [0.038, 0.008], [0.071, 0.029], [0.092, 0.062], [0.0999, 0.1], [0.0999, 0.4], [0, 0.4]] }\n[[parts]]\nname = \"drill-shank\"\nlink = \"head\"\nrole = \"shank\"\ntool = 2\nat = { xyz_mm = [0, 0, -129.6] }\nshape = { kind = \"revolve\", profile_mm = [[0, 0], [0.0999, 0], [2, 1.9], [2, 89.6], [0, 89.6]] }",
);

/// A sleeve on the lathe that W moves over the end of the bar, by its profile. It begins 40 mm in front of the bar.
macro_rules! sleeve {
    ($profile:literal) => {
        (
            "[[parts]]\nname = \"tailstock\"",
            concat!(
                "[[machine.links]]\nname = \"quill\"\njoint = { axis = \"W\", direction = [0, 0, 1] }\n",
                "[[parts]]\nname = \"sleeve\"\nlink = \"quill\"\nrole = \"fixture\"\nat = { xyz_mm = [0, 0, 240] }\n",
                "shape = { kind = \"revolve\", profile_mm = [",
                $profile,
                "] }\n[[parts]]\nname = \"tailstock\""
            ),
        )
    };
}

const CRASHES: &[Crash] = &[
    Crash {
        machine: "mill",
        fault: "the cutter stands in the block before the first move",
        change: Some(("start = { z_mm = 400 }", "start = { z_mm = 180 }")),
        program: "M3 S3000 G43 H1\nG1 Z50 F300\nM2",
        told: &[(0, COLLISION, "block:end-mill")],
    },
    Crash {
        machine: "mill",
        fault: "the holder stands against the stop before the first move",
        change: Some(("start = { z_mm = 400 }", "start = { x_mm = 55, z_mm = 185 }")),
        program: "M3 S3000 G43 H1\nG0 Z50\nM2",
        // The cutter's side is in the plane of the block's: no depth.
        told: &[(0, COLLISION, "stop:holder")],
    },
    Crash {
        machine: "press",
        fault: "drill and chuck stand wholly inside a block before the first move",
        change: Some((
            "at = { xyz_mm = [0, 0, 50] }\nshape = { kind = \"rounded-box\", size_mm = [80, 80, 20] }",
            "at = { xyz_mm = [0, 0, 141] }\nshape = { kind = \"rounded-box\", size_mm = [80, 80, 280] }",
        )),
        program: "M3 S800 G43 H1\nG1 Z95 F100\nM2",
        told: &[(0, COLLISION, "plate:drill"), (0, COLLISION, "plate:chuck")],
    },
    crash(
        "mill",
        "rapid down onto the rear jaw",
        "M3 S3000 G43 H1 G0 Z50\nG0 Y42\nG0 Z-20\nG0 Z50\nM2",
        &[(3, COLLISION, "rear-jaw:end-mill")],
    ),
    crash(
        "mill",
        "slot fed on until the holder meets the stop",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70\nG0 Z-5\nG1 X40 F500\nG1 X58\nG0 Z50\nM2",
        &[(5, COLLISION, "stop:holder")],
    ),
    crash(
        "mill",
        "plunge deeper than the flutes: the shank rubs",
        "M3 S3000 G43 H1 G0 Z5\nG1 Z-25 F100\nG1 Z-34\nG0 Z50\nM2",
        &[(3, COLLISION, "block:shank")],
    ),
    crash(
        "mill",
        "rapid into the top of the block",
        "M3 S3000 G43 H1 G0 Z50\nG0 X10\nG0 Z-3\nG0 Z50\nM2",
        &[(3, RAPID, "block:end-mill")],
    ),
    crash(
        "mill",
        "spindle never started",
        "S3000 G43 H1 G0 Z5\nG1 Z-2 F100\nG0 Z50\nM2",
        &[(2, STOPPED, "block:end-mill")],
    ),
    crash(
        "mill",
        "spindle oriented (M19) and not started again",
        "M3 S3000 G43 H1 G0 Z5\nM19\nG1 Z-2 F100\nG0 Z50\nM2",
        &[(3, STOPPED, "block:end-mill")],
    ),
    Crash {
        machine: "mill",
        fault: "spindle not started again after a stop (M0) on Haas's control",
        change: Some(("file = \"program.ngc\"", "file = \"program.ngc\"\ndialect = \"haas\"")),
        program: "M3 S3000 G43 H1 G0 Z5.\nM0\nG1 Z-2. F100.\nG0 Z50.\nM30",
        told: &[(3, STOPPED, "block:end-mill")],
    },
    crash(
        "mill",
        "M61 says that the long drill is in the spindle",
        "M61 Q2\nM3 S3000 G43 G0 Z20\nG0 Y42\nG0 Z-25\nM2",
        &[(4, COLLISION, "rear-jaw:drill")],
    ),
    crash(
        "mill",
        "spindle stopped in the cut",
        "M3 S3000 G43 H1 G0 Z5\nG1 Z-2 F100\nG1 X10\nM5\nG1 X20\nG0 Z50\nM2",
        &[(5, STOPPED, "block:end-mill")],
    ),
    crash(
        "mill",
        "tool change 20 mm above the block, the next tool 40 mm longer",
        "M3 S3000 G43 H1 G0 Z20\nT2 M6\nG43 H2 G0 Z50\nM2",
        &[(2, CHANGE, "block:drill")],
    ),
    crash(
        "mill",
        "tool length not taken up after a change",
        "M3 S3000 G43 H1 G0 Z100\nT2 M6\nG0 X20\nG0 Z5\nG0 Z100\nM2",
        &[(4, RAPID, "block:drill")],
    ),
    crash(
        "mill",
        "tool length cancelled",
        "M3 S3000 G43 H1 G0 Z50\nG49\nG0 Z5\nG0 Z150\nM2",
        &[(3, RAPID, "block:end-mill"), (3, COLLISION, "block:shank"), (3, COLLISION, "block:holder")],
    ),
    crash(
        "mill",
        "work offset that nobody has set",
        "M3 S3000 G55 G43 H1 G0 Z200\nG0 Z15\nG0 Z200\nM2",
        &[(2, RAPID, "block:end-mill"), (2, COLLISION, "block:shank"), (2, COLLISION, "block:holder")],
    ),
    crash(
        "mill",
        "rapid on through uncut stock after a cut",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70\nG0 Z-8\nG1 X-30 F300\nG0 X30\nG0 Z50\nM2",
        &[(5, RAPID, "block:end-mill")],
    ),
    crash(
        "mill",
        "rapid 2 mm beside the pocket that it came from",
        "M3 S3000 G43 H1 G0 Z5\nG1 Z-10 F100\nG1 X20\nG0 Z5\nG0 Y2\nG0 Z-9\nG0 Z50\nM2",
        &[(6, RAPID, "block:end-mill")],
    ),
    crash(
        "mill",
        "rapid 0.3 mm under the floor of a slot",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70\nG0 Z-5\nG1 X40 F300\nG0 X-70\nG0 Z-5.3\nG0 X40\nG0 Z50\nM2",
        &[(7, RAPID, "block:end-mill")],
    ),
    crash(
        "mill",
        "spindle stopped in a slot that is cut, and fed on into its end",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70\nG0 Z-5\nG1 X20 F300\nG1 X0\nM5\nG1 X19\nG1 X25\nG0 Z50\nM2",
        &[(8, STOPPED, "block:end-mill")],
    ),
    crash(
        "mill",
        "tool change in a pocket, the next tool longer than it is deep",
        "M3 S3000 G43 H1 G0 Z5\nG1 Z-30 F100\nT2 M6\nG43 H2 G0 Z50\nM2",
        &[(3, CHANGE, "block:drill")],
    ),
    crash(
        "mill",
        "drilled deeper at rapid rate than it was drilled",
        "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S1500 G43 H2 G0 Z5\nG1 Z-20 F150\nG0 Z5\nG0 Z-25\nG0 Z100\nM2",
        &[(6, RAPID, "block:drill")],
    ),
    Crash {
        machine: "mill",
        fault: "rapid into the slug that a hole saw has left around its pilot drill",
        change: Some((
            "shape = { kind = \"cylinder\", radius_mm = 4, height_mm = 90 }",
            "shape = { kind = \"revolve\", profile_mm = [[0, 0], [3, 2], [3, 38], [16, 38], [16, 8], [18, 8], [18, 42], [6, 42], [6, 90], [0, 90]] }",
        )),
        program: "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S300 G43 H2 G0 Z5\nG1 Z-14 F50\nG0 Z100\nT1 M6\nM3 S3000 G43 H1 G0 Z50\nG0 X10\nG0 Z-5\nG0 Z50\nM2",
        told: &[(9, RAPID, "block:end-mill")],
    },
    Crash {
        machine: "mill",
        fault: "saw blade of 0.15 mm on its arbor into the block at rapid rate",
        change: Some((
            "shape = { kind = \"cylinder\", radius_mm = 4, height_mm = 90 }",
            "shape = { kind = \"revolve\", profile_mm = [[0, 0], [16, 0], [16, 0.15], [4, 0.15], [4, 90], [0, 90]] }",
        )),
        program: "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S300 G43 H2 G0 Z50\nG0 X-80\nG0 Z-5\nG0 X-60\nG0 X-80\nG0 Z50\nM2",
        told: &[(6, UNRESOLVED, "block:drill")],
    },
    Crash {
        machine: "mill",
        fault: "ball of 0.2 mm at rapid rate 0.1 mm deep through what is not engraved",
        change: Some(ENGRAVER),
        program: "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S9000 G43 H2 G0 Z5\nG1 Z-0.1 F100\nG1 X10 Y3\nG0 X20\nG0 Z5\nG0 Z100\nM2",
        told: &[(6, RAPID, "block:drill")],
    },
    Crash {
        machine: "mill",
        fault: "ball of 0.2 mm at rapid rate 0.2 mm deeper than it has engraved",
        change: Some(ENGRAVER),
        program: "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S9000 G43 H2 G0 Z5\nG1 Z-0.1 F100\nG0 Z5\nG0 Z-0.3\nG0 Z100\nM2",
        told: &[(6, RAPID, "block:drill")],
    },
    Crash {
        machine: "mill",
        fault: "ball of 0.2 mm that cuts 0.4 mm engraves 0.5 mm deep: the shank rubs, and what it leaves is above the ball at the retract",
        change: Some(ENGRAVER),
        program: "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S9000 G43 H2 G0 Z5\nG1 Z-0.5 F100\nG1 X10\nG0 Z5\nG0 Z100\nM2",
        told: &[(4, COLLISION, "block:drill-shank"), (6, RAPID, "block:drill")],
    },
    crash(
        "mill",
        "holder meets the wall that a slot has left",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-75 Y25\nG0 Z-10\nG1 X-72 F500\nG1 Z-45\nG1 X-60\nG0 Z50\nM2",
        &[(6, COLLISION, "block:holder")],
    ),
    crash(
        "mill",
        "table driven into the column",
        "M3 S3000 G43 H1 G0 Z100\nG0 Y-80\nG0 Y-110\nG0 Y0\nM2",
        &[(3, COLLISION, "table:column")],
    ),
    crash(
        "mill",
        "sideways to the home position without a retract",
        "M3 S3000 G43 H1 G0 Z50\nG0 Z11\nG91 G28 X0\nG90 G0 Z50\nM2",
        &[(3, COLLISION, "stop:end-mill")],
    ),
    crash(
        "mill",
        "rapid through a guard of 0.3 mm",
        "M3 S3000 G43 H1 G0 Z80\nG0 X-280\nG0 Z250\nM2",
        &[(2, COLLISION, "guard:end-mill")],
    ),
    crash(
        "mill",
        "arc through the stop",
        "M3 S3000 G43 H1 G0 Z50\nG0 X60 Y-34.641\nG1 Z12 F500\nG3 X60 Y34.641 I-20 J34.641\nG0 Z50\nM2",
        &[(4, COLLISION, "stop:end-mill")],
    ),
    crash(
        "mill",
        "fourth pass of a loop",
        "M3 S3000 G43 H1 G0 Z50\nG0 Z12\no100 repeat [4]\nG91 G0 X22\nG90\no100 endrepeat\nG0 Z50\nM2",
        &[(4, COLLISION, "stop:end-mill")],
    ),
    crash(
        "mill",
        "G99 between two holes with the stop between them",
        "M3 S3000 G43 H1 G0 Z50\nG99 G81 X40 Y0 Z-5 R9 F200\nX110\nG80 G0 Z50\nM2",
        &[(3, COLLISION, "stop:end-mill")],
    ),
    crash(
        "mill",
        "table beyond its limit",
        "M3 S3000 G43 H1 G0 Z100\nG0 X290\nG0 X320\nG0 X0\nM2",
        &[(3, TRAVEL, "X")],
    ),
    crash(
        "mill",
        "head beyond its limit, after a crash on an earlier line",
        "M3 S3000 G43 H1 G0 Z50\nG0 Y-42\nG0 Z-20\nG0 Z320\nM2",
        &[(3, COLLISION, "front-jaw:end-mill"), (4, TRAVEL, "Z")],
    ),
    crash(
        "trunnion",
        "table tilted under a tool that has not retracted",
        "M3 S8000 G43 H1 G0 Z20\nG0 A-90\nG0 A0\nG0 Z200\nM2",
        &[(2, COLLISION, "platter:cutter")],
    ),
    crash(
        "trunnion",
        "clamp turned into the tool",
        "M3 S8000 G43 H1 G0 X0 Y60 Z100\nG0 Z-18\nG0 C90\nG0 Z100\nM2",
        &[(3, COLLISION, "clamp:cutter")],
    ),
    crash(
        "trunnion",
        "tool into the cradle",
        "M3 S8000 G43 H1 G0 Z100\nG0 X150\nG1 Z-10 F500\nG0 Z100\nM2",
        &[(3, COLLISION, "cradle:cutter")],
    ),
    crash(
        "trunnion",
        "holder into the clamp beside the cut",
        "M3 S8000 G43 H1 G0 X34.2 Y-70 Z100\nG0 Z-25\nG1 Y-40 F600\nG1 Y0\nG0 Z100\nM2",
        &[(4, COLLISION, "clamp:holder")],
    ),
    crash(
        "trunnion",
        "tilt beyond the limit of A",
        "M3 S8000 G43 H1 G0 Z300\nG0 A20\nG0 A45\nG0 A0\nM2",
        &[(3, TRAVEL, "A")],
    ),
    crash(
        "trunnion",
        "tool-centre-point control tilts the platter into the holder",
        "M3 S8000 G43.4 H1 G0 Z20\nG0 X0 Y-50\nG1 Z-40 F2000\nG1 A-88\nG1 A0\nG0 Z100\nM2",
        &[(4, COLLISION, "platter:holder")],
    ),
    crash(
        "fork",
        "head swung into a wall",
        "M3 S8000 G43 H1 G0 Z100\nG0 X50\nG0 Z20\nG0 B-22\nG0 B0\nG0 Z100\nM2",
        &[(4, COLLISION, "wall:ball-nose")],
    ),
    crash(
        "fork",
        "tool-centre-point control leans the spindle into a wall",
        "M3 S8000 G43.4 H1 G0 Z100\nG0 X70\nG0 Z5\nG1 B20 F3000\nG1 B0\nG0 Z100\nM2",
        &[(4, COLLISION, "wall:spindle")],
    ),
    crash(
        "fork",
        "ball into the bed",
        "M3 S8000 G43 H1 G0 Z100\nG0 X-180\nG0 Z-75\nG1 Z-84 F500\nG0 Z100\nM2",
        &[(4, COLLISION, "bed:ball-nose")],
    ),
    crash("fork", "gantry beyond its limit", "M3 S8000 G43 H1 G0 Z150\nG0 X-450\nM2", &[(2, TRAVEL, "X")]),
    crash(
        "horizontal",
        "pallet indexed before the tool is clear",
        "M3 S1000 G43 H1 G0 Z100\nG0 Z10\nG0 B90\nG0 Z100\nM2",
        &[(3, RAPID, "front-part:drill"), (3, COLLISION, "tombstone:drill")],
    ),
    crash(
        "horizontal",
        "drill through the part into the tombstone",
        "M3 S1000 G43 H1 G0 Z50\nG98 G81 X0 Y0 Z-30 R5 F100\nX30 Z-45\nG80 G0 Z100\nM2",
        &[(3, COLLISION, "tombstone:drill")],
    ),
    crash(
        "horizontal",
        "holder over the edge of the pallet",
        "M3 S1000 G43 H1 G0 Z200\nG0 Y-195\nG0 Z5\nG0 Z200\nM2",
        &[(3, COLLISION, "pallet:holder")],
    ),
    crash(
        "lathe",
        "turning on into the jaws",
        "G7 M3 S800 G0 X56 Z5\nG1 Z-100 F200\nG1 Z-163\nG0 X100\nG0 Z5\nM2",
        &[(3, COLLISION, "chuck:insert")],
    ),
    crash(
        "lathe",
        "rapid into the bar",
        "G7 M3 S800 G0 X80 Z5\nG0 Z-50\nG0 X50\nG0 X80\nM2",
        &[(3, RAPID, "bar:insert")],
    ),
    crash(
        "lathe",
        "rapid through the bar at the end of a cut",
        "G7 M3 S800 G0 X64 Z5\nG0 X58\nG1 Z-50 F200\nG0 X40\nG0 X100\nM2",
        &[(4, RAPID, "bar:insert")],
    ),
    crash(
        "lathe",
        "change to a longer tool in front of the bar",
        "G7 M3 S800 G0 X80 Z10\nG0 X0\nT2 M6\nG0 Z40\nM2",
        &[(3, CHANGE, "bar:drill")],
    ),
    crash(
        "lathe",
        "drill deeper than it is long: the holder meets the face",
        "G7 T2 M6 G43 H2 M3 S800\nG0 X0 Z10\nG1 Z-85 F100\nG1 Z-93\nG0 Z10\nM2",
        &[(4, COLLISION, "bar:drill-holder")],
    ),
    crash(
        "lathe",
        "groove deeper than the insert is high: the shank rubs",
        "G7 M3 S800 G0 X70 Z-50\nG1 X46 F50\nG1 X38\nG0 X70\nG0 Z5\nM2",
        &[(3, COLLISION, "bar:tool-shank")],
    ),
    crash(
        "lathe",
        "turret retracted into the tailstock",
        "G7 M3 S800 G0 X50 Z5\nG0 Z215\nG0 X200\nM2",
        &[(2, COLLISION, "tailstock:turret")],
    ),
    Crash {
        machine: "fork",
        fault: "the ram rises while the head swings through the upright",
        change: Some((
            "[program]\nfile = \"program.ngc\"\nstart = { z_mm = 400 }",
            "[[parts]]\nname = \"ceiling\"\nrole = \"fixture\"\nat = { xyz_mm = [-300, 0, 729.6] }\nshape = { kind = \"rounded-box\", size_mm = [400, 400, 20] }\n[program]\nfile = \"program.ngc\"\nstart = { x_mm = -300, z_mm = 150 }\nstep_deg = 10",
        )),
        program: "G43.4 H1\nG1 B-5 F3000\nG1 Z20\nG1 B5\nG1 Z-30\nG1 B0\nM2",
        told: &[(4, COLLISION, "ram:ceiling")],
    },
    Crash {
        machine: "lathe",
        fault: "sleeve over the turned end, its bore 1 mm too small",
        change: Some(sleeve!("[24, 0], [40, 0], [40, 60], [0, 60], [0, 50], [24, 50]")),
        program: "G7 M3 S800 G0 X64 Z5\nG0 X50\nG1 Z-35 F200\nG1 X64\nG0 Z5\nG0 X200 Z70\nG0 W-70\nG0 W0\nM2",
        told: &[(7, COLLISION, "bar:sleeve")],
    },
    Crash {
        machine: "lathe",
        fault: "sleeve of sheet 0.1 mm thick over the turned end, its bore 1 mm too small",
        change: Some(sleeve!("[24, 0], [24.1, 0], [24.1, 60], [24, 60]")),
        program: "G7 M3 S800 G0 X64 Z5\nG0 X50\nG1 Z-35 F200\nG1 X64\nG0 Z5\nG0 X200 Z70\nG0 W-70\nG0 W0\nM2",
        told: &[(7, UNRESOLVED, "bar:sleeve")],
    },
    Crash {
        machine: "lathe",
        fault: "insert between two jaws of the chuck as drawn, which turns",
        change: Some((
            "link = \"spindle\"\nrole = \"fixture\"",
            "link = \"spindle\"\nrole = \"fixture\"\nat = { rpy_deg = [0, 0, 60] }",
        )),
        program: "G7 M3 S800 G0 X56 Z5\nG1 Z-100 F200\nG1 Z-163\nG0 X100\nG0 Z5\nM2",
        told: &[(3, UNRESOLVED, "chuck:insert")],
    },
    Crash {
        machine: "lathe",
        fault: "insert and shank into a hole milled across the bar, which turns",
        change: Some((
            "diameter_mm = 16 }]",
            "diameter_mm = 16 }, { number = 3, diameter_mm = 36 }]\n[[parts]]\nname = \"mill\"\nlink = \"turret\"\nrole = \"cutter\"\nturns = \"own\"\ntool = 3\nat = { xyz_mm = [0, 0, 14], rpy_deg = [0, 90, 0] }\nshape = { kind = \"cylinder\", radius_mm = 18, height_mm = 40 }",
        )),
        program: "G7 T3 M6\nM3 S2000\nG0 X80 Z-50\nG1 X0 F200\nG0 X80\nT1 M6\nM3 S800\nG0 X20\nG0 X80\nM2",
        told: &[(8, RAPID, "bar:insert"), (8, UNRESOLVED, "bar:tool-shank")],
    },
    crash(
        "lathe",
        "parting off with the spindle stopped",
        "G7 S800 G0 X70 Z-50\nG1 X50 F50\nG0 X70\nM2",
        &[(2, STOPPED, "bar:insert")],
    ),
    crash(
        "lathe",
        "beyond the centre and the limit of X",
        "G7 M3 S800 G0 X80 Z40\nG0 X-50\nG0 X80\nM2",
        &[(2, TRAVEL, "X")],
    ),
    crash(
        "press",
        "through hole too deep: the chuck meets the jaw",
        "M3 S800 G43 H1 G0 Z5\nG1 Z-22 F100\nG1 Z-33\nG0 Z50\nM2",
        &[(3, COLLISION, "jaw:chuck")],
    ),
    Crash {
        machine: "press",
        fault: "rapid into a jaw that stands on the frame, as the quill does",
        change: Some(("xyz_mm = [30, 0, 80]", "xyz_mm = [0, 0, 80]")),
        program: "M3 S800 G43 H1 G0 Z60\nG0 Z20\nG0 Z60\nM2",
        told: &[(2, COLLISION, "jaw:drill")],
    },
];

const GOOD: &[Good] = &[
    good(
        "mill",
        "face in three passes and return above the block",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70 Y-20\nG0 Z-1\nG1 X62 F800\nG0 Z5\nG0 X-70 Y-12\nG0 Z-1\nG1 X62\nG0 Z5\nG0 X-70 Y-4\nG0 Z-1\nG1 X62\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "slot entered by feed from outside",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70 Y0\nG0 Z-8\nG1 X40 F300\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "holes with G81, G98 over the stop",
        "M3 S3000 G43 H1 G0 Z50\nG98 G81 X-40 Y0 Z-10 R2 F200\nX0\nX40\nX110\nG80\nM2",
    ),
    good(
        "mill",
        "counterbores with a dwell, G82",
        "M3 S3000 G43 H1 G0 Z50\nG99 G82 X-20 Y10 Z-6 R3 P0.5 F150\nX20\nG80 G0 Z50\nM2",
    ),
    good("mill", "thread by a tap, G84", "M3 S400 G43 H1 G0 Z50\nG98 G84 X0 Y0 Z-12 R5 F400\nG80 G0 Z50\nM2"),
    good("mill", "bored and fed out again, G85", "M3 S1000 G43 H1 G0 Z50\nG98 G85 X0 Y0 Z-20 R2 F120\nG80 G0 Z50\nM2"),
    good(
        "mill",
        "drilled with a tool that is changed at a safe height",
        "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S1500 G43 H2 G0 Z50\nG81 X0 Y0 Z-40 R2 F150\nG80 G0 Z100\nM2",
    ),
    good(
        "mill",
        "helix into a pocket and once around",
        "M3 S3000 G43 H1 G0 Z50\nG0 X10 Y0\nG0 Z1\nG3 X10 Y0 Z-4 I-10 J0 P3 F400\nG3 X10 Y0 I-10 J0\nG1 X0 Y0\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "thread milled in a helix upwards",
        "M3 S3000 G43 H1 G0 Z50\nG0 X0 Y0\nG1 Z-12 F100\nG1 X4\nG3 X4 Y0 Z-10.5 I-4 J0\nG3 X4 Y0 Z-9 I-4 J0\nG1 X0\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "arc around the stop",
        "M3 S3000 G43 H1 G0 Z50\nG0 X80 Y-40\nG1 Z12 F800\nG3 X80 Y40 I-20 J40\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "contour with cutter compensation",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70 Y-50\nG0 Z30\nG0 X-75 Y-20\nG0 Z-4\nG41 D1 G1 X-45 Y-25 F400\nG1 Y25\nG1 X45\nG40 G1 X45 Y20\nG0 Z50\nM2",
    ),
    good("mill", "pecks with G83", "M3 S3000 G43 H1 G0 Z50\nG98 G83 X0 Y0 Z-25 R2 Q6 F150\nX20 Y10\nG80 G0 Z50\nM2"),
    good(
        "mill",
        "pocket in three levels, entered at rapid rate",
        "M3 S3000 G43 H1 G0 Z5\nG1 Z-5 F200\nX15\nY8\nX0\nY0\nG0 Z5\nG0 Z-4.5\nG1 Z-10\nX15\nY8\nX0\nY0\nG0 Z5\nG0 Z-9.5\nG1 Z-15\nX15\nY8\nX0\nY0\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "back along a slot at rapid rate, on its floor",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70\nG0 Z-8\nG1 X40 F300\nG0 X-70\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "face and return at the depth of the cut",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70 Y-20\nG0 Z-1\nG1 X62 F800\nG0 X-70\nG0 Y-12\nG1 X62\nG0 X-70\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "shank deep in what was cut before",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-75 Y0\nG0 Z-12\nG1 X20 F500\nG1 Y-4\nG1 X-75\nG1 Y4\nG1 X20\nG0 X-75\nG0 Y0\nG0 Z-34\nG1 X0\nG0 X-75\nG0 Z50\nM2",
    ),
    good(
        "mill",
        "spindle stopped in a slot that is cut, and backed out by feed",
        "M3 S3000 G43 H1 G0 Z50\nG0 X-70\nG0 Z-5\nG1 X20 F300\nM5\nG1 X-70\nG0 Z50\nM2",
    ),
    Good {
        machine: "mill",
        work: "engraved 0.1 mm deep with a ball of 0.2 mm",
        change: Some(ENGRAVER),
        program: "M3 S3000 G43 H1 G0 Z100\nT2 M6\nM3 S9000 G43 H2 G0 Z5\nG1 Z-0.1 F100\nG1 X3 Y1\nG3 X6 Y4 J3\nG0 Z5\nG0 X0 Y3\nG1 Z-0.1\nG1 X0.3 Y3.7\nG1 X5.5\nG0 Z100\nM2",
    },
    good("mill", "home after a retract", "M3 S3000 G43 H1 G0 Z5\nG1 Z-3 F100\nG0 Z60\nG91 G28 Z0\nG91 G28 X0\nM2"),
    good(
        "mill",
        "subroutine called at three places",
        "o10 sub\nG91 G1 Z-7 F100\nG0 Z7\nG90\no10 endsub\nM3 S3000 G43 H1 G0 Z50\nG0 X-30 Y0\nG0 Z2\no10 call\nG0 X0\no10 call\nG0 X30\no10 call\nG0 Z50\nM2",
    ),
    good(
        "trunnion",
        "tilt and drill, retracted in between",
        "M3 S8000 G43 H1 G0 Z200\nG0 A-60\nG0 Y30 Z60\nG0 Z200\nG0 A0 C90\nG0 X0 Y0 Z5\nG1 Z-8 F200\nG0 Z200\nM2",
    ),
    good(
        "trunnion",
        "four faces of the top edge, indexed about C",
        "M3 S8000 G43 H1 G0 X0 Y-40 Z100\nG0 Z-5\nG1 Y-33 F400\nG1 Y-40\nG0 Z100\nG0 C180\nG0 Z-5\nG1 Y-33\nG1 Y-40\nG0 Z100\nG0 C0\nM2",
    ),
    good(
        "trunnion",
        "swarf along the block under tool-centre-point control",
        "M3 S8000 G43.4 H1 G0 Z60\nG0 X-33 Y-60\nG0 Z-5\nG1 X-33 Y-20 A-10 F1500\nG1 Y20 A-5\nG1 Y50 A0\nG0 Z60\nG49 G0 Z200\nM2",
    ),
    good(
        "trunnion",
        "circle turned by C under a standing tool",
        "M3 S8000 G43 H1 G0 X20 Y0 Z30\nG0 Z2\nG1 Z-2 F200\nG1 C360 F2000\nG0 Z100\nM2",
    ),
    good(
        "fork",
        "ball-nose over the block, leaning away from the wall",
        "M3 S8000 G43.4 H1 G0 Z100\nG0 X70\nG0 Z5\nG1 Z-2 B-20 F2000\nG1 X-80\nG1 Z20 B0\nG0 Z100\nM2",
    ),
    good(
        "fork",
        "line across the block, entered from outside",
        "M3 S8000 G43 H1 G0 Z100\nG0 X75 Y-80\nG0 Z-10\nG1 Y80 F1500\nG0 Z100\nM2",
    ),
    good(
        "fork",
        "side of the block with the head lying",
        "M3 S8000 G43.4 H1 G0 X-150 Y0 Z100\nG1 B-80 F4000\nG1 X-115 Z-20\nG1 X-97\nG1 X-140\nG1 Z100\nG1 B0\nM2",
    ),
    good(
        "horizontal",
        "drill a part, index clear of the corners, drill the other",
        "M3 S1000 G43 H1 G0 Z100\nG98 G81 X0 Y0 Z-20 R5 F100\nX40 Y30\nG80 G0 Z100\nG0 B180\nG98 G81 X0 Y0 Z-20 R5\nG80 G0 Z100\nM2",
    ),
    good(
        "horizontal",
        "index at the least distance at which the corners clear",
        "M3 S1000 G43 H1 G0 Z50\nG0 B90\nG0 B180\nG0 B360\nM2",
    ),
    good(
        "horizontal",
        "slot entered from outside, fourth axis turning in the air",
        "M3 S1000 G43 H1 G0 Z60\nG0 X-100\nG0 Z-4\nG1 X0 F200\nG1 Z20\nG0 Z60\nG0 B-90\nG0 B0\nM2",
    ),
    good(
        "lathe",
        "turn, face and retract",
        "G7 M3 S800 G0 X64 Z5\nG0 X58\nG1 Z-100 F200\nG1 X62\nG0 Z5\nG0 X62\nG0 Z-0.5\nG1 X-1 F100\nG0 Z5\nG0 X200\nM2",
    ),
    good(
        "lathe",
        "rapid back along what was turned",
        "G7 M3 S800 G0 X64 Z5\nG0 X58\nG1 Z-50 F200\nG0 X60\nG0 Z5\nG0 X50\nG1 Z-20 F200\nG0 X52\nG0 Z5\nG0 X50\nG0 Z-19\nG1 Z-30 F200\nG0 X100\nM2",
    ),
    good(
        "lathe",
        "thread in one cycle, G76",
        "G7 M3 S300 G0 X64 Z5\nG76 P1.5 Z-30 I-4 J0.4 K1.84 R1 Q29.5 H1 E0 L0\nG0 X200\nM2",
    ),
    good(
        "lathe",
        "thread pass by pass, G33",
        "G7 M3 S300 G0 X64 Z5\nG0 X59\nG33 Z-30 K1.5\nG0 X64\nG0 Z5\nG0 X58.5\nG33 Z-30 K1.5\nG0 X64\nG0 Z5\nM2",
    ),
    good(
        "lathe",
        "groove within the insert's height",
        "G7 M3 S800 G0 X70 Z-50\nG1 X48 F50\nG4 P0.5\nG0 X70\nG0 Z5\nM2",
    ),
    good(
        "lathe",
        "drill after a change at a safe place",
        "G7 M3 S800 G0 X200 Z70\nT2 M6\nM3 S800 G43 H2 G0 Z50\nG0 X0\nG0 Z5\nG1 Z-60 F100\nG0 Z50\nG0 X200\nM2",
    ),
    Good {
        machine: "lathe",
        work: "sleeve over the turned end",
        change: Some(sleeve!("[26, 0], [40, 0], [40, 60], [0, 60], [0, 50], [26, 50]")),
        program: "G7 M3 S800 G0 X64 Z5\nG0 X50\nG1 Z-35 F200\nG1 X64\nG0 Z5\nG0 X200 Z70\nG0 W-70\nG0 W0\nM2",
    },
    good("press", "through hole and back", "M3 S800 G43 H1 G0 Z5\nG1 Z-24 F100\nG0 Z60\nM2"),
    good("press", "hole with a dwell at its bottom", "M3 S800 G43 H1 G0 Z30\nG98 G82 Z-10 R3 P0.3 F80\nG80\nM2"),
];

fn scene(machine: &str, change: Option<(&str, &str)>, program: &str) -> Scene {
    load(machine, &changed(machine, change), program)
}

/// The text of a machine's scene.
fn changed(machine: &str, change: Option<(&str, &str)>) -> String {
    let (_, text) = MACHINES.iter().find(|(name, _)| *name == machine).unwrap();
    let Some((from, to)) = change else { return (*text).to_owned() };
    assert_eq!(text.matches(from).count(), 1, "{machine}: {from}");
    text.replacen(from, to, 1)
}

fn load(machine: &str, text: &str, program: &str) -> Scene {
    in_memory(machine, &[("scene.toml", text), ("program.ngc", program)])
}

/// All that `check` has to say, in the order of the program: line, kind, parts or axis.
fn told(scene: &Scene) -> Vec<(u32, &'static str, String)> {
    let outcome = run_own(scene, &with_zones(&[]));
    let events = outcome.events.iter().map(|e| (e.first.line, e.kind.name(), scene.pair_name(e.pair)));
    let over = outcome.over_travel.iter().map(|over| (over.line, TRAVEL, over.cause.axis.to_string()));
    let mut told: Vec<_> = events.chain(over).collect();
    // Within a line the order of what happens is not the table's business.
    told.sort();
    told
}

fn wanted(told: &[Told]) -> Vec<(u32, &'static str, String)> {
    let mut wanted: Vec<_> = told.iter().map(|&(line, kind, what)| (line, kind, what.to_owned())).collect();
    wanted.sort();
    wanted
}

#[test]
fn every_planted_crash_is_found_at_its_line_and_nothing_else_is_told() {
    let mut wrong = String::new();
    for Crash { machine, fault, change, program, told: planted } in CRASHES {
        let found = told(&scene(machine, *change, program));
        if found != wanted(planted) || found.is_empty() {
            let _ = writeln!(wrong, "{machine}: {fault}\n{program}\n  planted {planted:?}\n  found   {found:?}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn good_programs_are_clear() {
    let mut wrong = String::new();
    for Good { machine, work, change, program } in GOOD {
        let found = told(&scene(machine, *change, program));
        if !found.is_empty() {
            let _ = writeln!(wrong, "{machine}: {work}\n{program}\n  found {found:?}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A workpiece of the lathe with a bore of 44 mm, 50 mm deep, and one of 20 mm in its bottom, 10 mm deep: 14 % of its volume.
const TUBE: &str = "{ kind = \"revolve\", profile_mm = [[0, 0], [30, 0], [30, 200], [22, 200], [22, 150], [10, 150], [10, 140], [0, 140]] }";

/// A lathe without a joint for its spindle, and with two jaws beside the plane in which its tools move: bars and tubes are cut, and turn the jaws.
#[test]
fn a_workpiece_with_a_bore_is_cut_and_turns_its_chuck() {
    let joint = "[[machine.links]]\nname = \"spindle\"\njoint = { axis = \"C\", direction = [0, 0, 1] }\n";
    let jaws = "size_mm = [50, 30, 40] }\nat = { xyz_mm = [56, 0, 20] }\nrepeat = { kind = \"around\", count = 3 }";
    let two = "size_mm = [30, 50, 40] }\nat = { xyz_mm = [0, 56, 20] }\nrepeat = { kind = \"around\", count = 2 }";
    let bar = "{ kind = \"cylinder\", radius_mm = 30, height_mm = 200 }";
    let text = [(joint, ""), ("link = \"spindle\"\n", ""), (jaws, two)]
        .into_iter()
        .fold(changed("lathe", None), |text, (from, to)| text.replace(from, to));
    let turned = "G7 M3 S800 G0 X64 Z5\nG0 X58\nG1 Z-50 F200\nG0 X60\nG0 Z5\nG0 X200\nG0 Z-170\n";
    let jaws_met = vec![(8, UNRESOLVED, "chuck:insert"), (8, UNRESOLVED, "chuck:tool-shank")];
    let into_jaws = format!("{turned}G0 X70\nG0 X200\nM2");
    // The drill, 16 mm, into the bore at rapid rate: 1 mm from its walls and bottom, and 1 mm in each.
    let bore = |x: &str, z: &str| format!("G7 T2 M6 G43 H2 M3 S800\nG0 X{x} Z10\nG0 Z{z}\nG0 Z10\nM2");
    for (shape, program, planted) in [
        (bar, into_jaws.clone(), jaws_met.clone()),
        (TUBE, into_jaws, jaws_met),
        (bar, bore("0", "-30"), vec![(3, RAPID, "bar:drill")]),
        (TUBE, bore("0", "-59"), vec![]),
        (TUBE, bore("0", "-61"), vec![(3, RAPID, "bar:drill")]),
        (TUBE, bore("26", "-30"), vec![]),
        (TUBE, bore("30", "-30"), vec![(3, RAPID, "bar:drill")]),
        (TUBE, bore("6", "-59"), vec![(3, RAPID, "bar:drill")]),
    ] {
        let found = told(&load("lathe", &text.replacen(bar, shape, 1), &program));
        assert_eq!(found, wanted(&planted), "{shape}\n{program}");
    }
}

/// Where nothing may be cut, the cutter of a good program collides with the workpiece: so it does cut, and is clear by no accident.
#[test]
fn good_programs_cut() {
    let mut idle = Vec::new();
    for Good { machine, work, change, program } in GOOD {
        let uncut = changed(machine, *change).replace("role = \"workpiece\"", "role = \"fixture\"");
        let found = told(&load(machine, &uncut, program));
        let cutters = ["end-mill", "drill", "cutter", "ball-nose", "insert", "shank", "sleeve"];
        assert!(
            found.iter().all(|(_, _, pair)| cutters.iter().any(|cutter| pair.ends_with(cutter))),
            "{work}: {found:?}"
        );
        if found.is_empty() {
            idle.push(*work);
        }
    }
    assert_eq!(idle, ["arc around the stop", "index at the least distance at which the corners clear"]);
}

#[test]
fn the_table_has_thirty_crashes_and_thirty_good_programs_on_five_machines() {
    assert!(CRASHES.len() >= 30 && GOOD.len() >= 30);
    for (machine, _) in MACHINES {
        let crashes = CRASHES.iter().filter(|crash| crash.machine == machine).count();
        let good = GOOD.iter().filter(|good| good.machine == machine).count();
        assert!(crashes >= 3 && good >= 2, "{machine}: {crashes} crashes, {good} good programs");
    }
    for kind in [COLLISION, RAPID, STOPPED, CHANGE, TRAVEL] {
        assert!(CRASHES.iter().any(|crash| crash.told.iter().any(|told| told.1 == kind)), "{kind}");
    }
}

/// The table as a page of the documentation.
fn table() -> String {
    let mut text = String::from(
        "# Planted crashes\n\nPrograms with a fault, what `bvbench check` finds in them, and programs without one, on six small machines\n\
        (`tests/crashes/*.toml`). `tests/crashes.rs` runs them all: each fault must be found at its line with its parts, and nothing\n\
        else may be told. This page is written by `BVBENCH_WRITE_DOCS=1 cargo test --test crashes`.\n",
    );
    let _ = writeln!(
        text,
        "\n{} of {} faults are found, {} of {} good programs are clear.\n",
        CRASHES.len(),
        CRASHES.len(),
        GOOD.len(),
        GOOD.len()
    );
    text += "The workpiece is cut at a resolution of 0.1 mm, by the engraving cutter at 0.05 mm. What is not looked for: [what `check` does not see](check.md#what-check-does-not-see).\n";
    text += "\n| machine | fault | the line | found |\n|---|---|---|---|\n";
    for Crash { machine, fault, program, told, .. } in CRASHES {
        let line = told.iter().map(|told| told.0).min().unwrap_or(0);
        let block = match line {
            0 => "before the first move".to_owned(),
            line => format!("{line}: `{}`", program.lines().nth(line as usize - 1).unwrap()),
        };
        let found = told.iter().map(|(at, kind, what)| {
            let at = if *at == line { String::new() } else { format!("line {at}: ") };
            let kind = kind.replace('-', " ");
            if kind == "over travel" { format!("{at}over-travel of {what}") } else { format!("{at}{kind} `{what}`") }
        });
        let found = found.collect::<Vec<_>>().join("; ");
        let _ = writeln!(text, "| {machine} | {fault} | {block} | {found} |");
    }
    text += "\n| machine | good program | lines |\n|---|---|---|\n";
    for Good { machine, work, program, .. } in GOOD {
        let _ = writeln!(text, "| {machine} | {work} | {} |", program.lines().count());
    }
    text
}

#[test]
fn the_documentation_has_the_table() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/crashes.md");
    if std::env::var_os("BVBENCH_WRITE_DOCS").is_some() {
        std::fs::write(&file, table()).unwrap();
    }
    let documented = std::fs::read_to_string(&file).unwrap();
    assert!(documented == table(), "docs/crashes.md is not the table: write it with BVBENCH_WRITE_DOCS=1");
}
