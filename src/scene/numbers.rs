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
    let number = match value.get_ref() {
        DeValue::Float(float) => float.as_str(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
        DeValue::Array(array) => return array.iter().find_map(|value| in_value(key, value)),
        DeValue::Table(table) => return too_large(table),
        _ => return None,
    };
    let is_too_large = number.parse::<f64>().is_ok_and(|x| x.abs() > LARGEST && !number.contains("inf"));
    is_too_large.then(|| {
        let message =
            format!("{key}: {number} is beyond {LARGEST:e}, the largest length, angle or rate; is the unit right?");
        (value.span(), message)
    })
}
