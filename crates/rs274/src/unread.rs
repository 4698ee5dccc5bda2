//! Names of codes of Fanuc's and Haas's controls that are not read, for messages (Haas's mill and lathe operator's manuals, "G-codes"; Fanuc's operator's
//! manual, "Preparatory function").

use super::dialect::Dialect;

/// What an unread G code does on the control. `tenths` is ten times its number.
pub(super) const fn unread_g(tenths: i32, dialect: Dialect, lathe: bool) -> Option<&'static str> {
    match dialect {
        Dialect::Fanuc => of_fanuc(tenths),
        Dialect::Haas if lathe => of_haas_lathes(tenths),
        Dialect::Haas => of_haas_mills(tenths),
        Dialect::LinuxCnc | Dialect::Grbl => None,
    }
}

const fn of_fanuc(tenths: i32) -> Option<&'static str> {
    Some(match tenths {
        71 | 1070 => "cylindrical interpolation",
        121 | 131 | 1120 | 1130 => "polar coordinate interpolation",
        290 => "the return from the reference position",
        450..=480 if tenths % 10 == 0 => "a move longer or shorter by a tool offset (G45 to G48)",
        600 => "positioning from one side",
        660 | 661 => "a modal macro call",
        _ => return None,
    })
}

const fn of_haas_mills(tenths: i32) -> Option<&'static str> {
    Some(match tenths {
        290 => "the return from the reference point",
        350 | 360 | 370 | 1360 => "an automatic measurement by probe (G35 to G37, G136)",
        470 => "text engraving",
        600 => "positioning from one side",
        660 | 661 => "a modal macro call",
        770 => "the back bore cycle",
        1070 => "cylindrical mapping",
        1410 => "3D+ cutter compensation",
        1430 => "5-axis tool length compensation",
        1500 => "general purpose pocket milling",
        1530 | 1550 | 1610..=1660 | 1690 if tenths % 10 == 0 => "a 5-axis cycle of holes (G153 to G169)",
        1560 => "broaching",
        1740 | 1840 => "a rigid tap aside from the vertical (G174, G184)",
        1880 => "the program from the pallet schedule",
        2530 | 2680 | 2690 => "the feature coordinate system (G253, G268, G269)",
        2540 | 2550 => "the dynamic work offset (G254, G255)",
        2660 => "the rapid move of a share of the rapid rate",
        _ => return None,
    })
}

const fn of_haas_lathes(tenths: i32) -> Option<&'static str> {
    Some(match tenths {
        50 => "fine spindle motion",
        290 => "the return from the reference point",
        660 | 661 => "a modal macro call",
        770 => "flatting by a live tool",
        950 | 1860 | 1950 | 1960 => "a tap by a live tool (G95, G186, G195, G196)",
        1050 => "the bar feeder",
        1070 => "cylindrical mapping",
        1120 | 1130 => "XY to XC interpolation (G112, G113)",
        1560 => "broaching",
        1840 => "reverse tapping",
        1980 | 1990 => "synchronous spindles (G198, G199)",
        2000 => "indexing on the fly",
        2410..=2490 if tenths % 10 == 0 => "a radial cycle of holes (G241 to G249)",
        _ => return None,
    })
}
