//! Detects numbers of a scene file that are too large to be intended.

use super::program::Nonsense;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Largest length, angle or rate of a scene file, in mm, degrees or either per minute: the farthest that a program may move an axis. Larger
/// numbers no longer resolve tenths of micrometres.
const LARGEST: f64 = rs274::interpret::FARTHEST;

/// The first finite number beyond [`LARGEST`]. A `direction` is exempt, because its length has no meaning.
pub(super) fn too_large(table: &DeTable<'_>) -> Option<Nonsense> {
    let meant = |key: &str| key != "direction";
    table.iter().filter(|(key, _)| meant(key.get_ref())).find_map(|(key, value)| in_value(key.get_ref(), value))
}

fn in_value(key: &str, value: &Spanned<DeValue<'_>>) -> Option<Nonsense> {
    let (number, is_too_large) = match value.get_ref() {
        DeValue::Float(float) => {
            let is_too_large = |x: f64| x.abs() > LARGEST && !float.as_str().contains("inf");
            (float.to_string(), float.as_str().parse().is_ok_and(is_too_large))
        }
        // What does not fit 128 bits is too large as well.
        DeValue::Integer(integer) => {
            let number = i128::from_str_radix(integer.as_str(), integer.radix());
            (integer.to_string(), number.map_or(true, |number| number.unsigned_abs() as f64 > LARGEST))
        }
        DeValue::Array(array) => return array.iter().find_map(|value| in_value(key, value)),
        DeValue::Table(table) => return too_large(table),
        _ => return None,
    };
    is_too_large.then(|| {
        let message =
            format!("{key}: {number} is beyond {LARGEST:e}, the largest length, angle or rate; is the unit right?");
        (value.span(), message)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_base_are_limited() {
        let message = |text: &str| {
            let text = format!("length = {text}");
            too_large(DeTable::parse(&text).unwrap().get_ref()).map(|(_, message)| message)
        };
        for fine in
            ["1e9", "-1e9", "1_000_000_000", "0x3B9A_CA00", "0o7346545000", "0b1010", "inf", "-inf", "nan", "0x0"]
        {
            assert_eq!(message(fine), None, "{fine}");
        }
        for large in [
            "1.1e9",
            "1_000_000_001",
            "-1_000_000_001",
            "0x3B9A_CA01",
            "0x7FFF_FFFF_FFFF_FFFF",
            "0o7346545001",
            "0b1111111111111111111111111111111111111111",
            "99999999999999999999999999999999999999999999999",
        ] {
            assert!(message(large).is_some_and(|message| message.contains("is beyond 1e9")), "{large}");
        }
    }
}
