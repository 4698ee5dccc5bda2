//! What client and server share: policies, identities, times, and numbers in the type that a node has.

use crate::config::{Mode, Security, User};
use opcua::client::IdentityToken;
use opcua::crypto::SecurityPolicy;
use opcua::types::{DateTime, MessageSecurityMode, Variant};
use std::path::Path;
use std::str::FromStr;
use std::time::{SystemTime, UNIX_EPOCH};

/// Ticks of the epoch of Unix, in which `DateTime` of OPC UA counts from 1601.
const UNIX_EPOCH_TICKS: i64 = 116_444_736_000_000_000;

/// The policy of a configuration.
pub(crate) fn policy(security: &Security) -> SecurityPolicy {
    SecurityPolicy::from_str(&security.policy).unwrap_or(SecurityPolicy::Unknown)
}

/// The mode of a configuration.
pub(crate) const fn mode(security: &Security) -> MessageSecurityMode {
    match security.mode {
        Mode::None => MessageSecurityMode::None,
        Mode::Sign => MessageSecurityMode::Sign,
        Mode::SignAndEncrypt => MessageSecurityMode::SignAndEncrypt,
    }
}

/// Who the configuration says that asks.
///
/// # Errors
/// When a certificate or key cannot be read.
pub(crate) fn identity(security: &Security) -> Result<IdentityToken, String> {
    match &security.user {
        User::Anonymous => Ok(IdentityToken::Anonymous),
        User::Name { name, password } => Ok(IdentityToken::new_user_name(name.clone(), password.clone())),
        User::Certificate { certificate, key } => IdentityToken::new_x509_path(certificate, key)
            .map_err(|error| format!("cannot read {} or {}: {error}", certificate.display(), key.display())),
    }
}

/// Keeps other users from reading the private key in a folder of certificates. Call it before and after the library may make one: it makes the key
/// with the process's default permissions.
///
/// # Errors
/// When a permission cannot be set.
pub(crate) fn keep_private(security: &Security, pki: &Path) -> Result<(), String> {
    let kept = if security.creates_certificate { keep_key_private(pki) } else { Ok(()) };
    kept.map_err(|error| format!("cannot protect the private key in {}: {error}", pki.display()))
}

#[cfg(unix)]
fn keep_key_private(pki: &Path) -> std::io::Result<()> {
    use std::fs;
    use std::os::unix::fs::{DirBuilderExt as _, PermissionsExt as _};
    let folder = pki.join("private");
    let key = folder.join("private.pem");
    if key.exists() {
        return fs::set_permissions(key, fs::Permissions::from_mode(0o600));
    }
    if folder.exists() { Ok(()) } else { fs::DirBuilder::new().recursive(true).mode(0o700).create(folder) }
}

/// Files have no mode here.
#[cfg(not(unix))]
fn keep_key_private(_pki: &Path) -> std::io::Result<()> {
    Ok(())
}

/// A time of OPC UA from ticks.
pub(crate) fn date(ticks: i64) -> DateTime {
    DateTime::from(ticks)
}

/// Nanoseconds since the epoch of Unix; the nearest that can be told of a time outside 1678 to 2262.
pub(crate) const fn unix_ns(ticks: i64) -> i64 {
    if ticks == 0 { 0 } else { ticks.saturating_sub(UNIX_EPOCH_TICKS).saturating_mul(100) }
}

/// The clock of this computer, ns since the epoch of Unix.
pub(crate) fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

/// A number in the type of another value of the same node; `None` where that type does not hold it. A Boolean holds 0 and 1.
pub(crate) fn like(template: &Variant, number: u32) -> Option<Variant> {
    Some(match template {
        Variant::Boolean(_) => (number <= 1).then_some(Variant::Boolean(number == 1))?,
        Variant::SByte(_) => Variant::SByte(i8::try_from(number).ok()?),
        Variant::Byte(_) => Variant::Byte(u8::try_from(number).ok()?),
        Variant::Int16(_) => Variant::Int16(i16::try_from(number).ok()?),
        Variant::UInt16(_) => Variant::UInt16(u16::try_from(number).ok()?),
        Variant::Int32(_) => Variant::Int32(i32::try_from(number).ok()?),
        Variant::UInt32(_) => Variant::UInt32(number),
        Variant::Int64(_) => Variant::Int64(number.into()),
        Variant::UInt64(_) => Variant::UInt64(number.into()),
        Variant::Float(_) => Variant::Float(number as f32),
        Variant::Double(_) => Variant::Double(number.into()),
        _ => return None,
    })
}

/// The number in a value.
pub(crate) fn number(value: &Variant) -> Option<f64> {
    match value {
        Variant::Boolean(value) => Some(f64::from(u8::from(*value))),
        other => other.as_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_a_hundred_nanoseconds_from_1601() {
        let ticks = DateTime::ymd_hms(1970, 1, 1, 0, 0, 1).ticks();
        assert_eq!(unix_ns(ticks), 1_000_000_000);
        assert_eq!(date(ticks).ticks(), ticks);
        assert_eq!(unix_ns(DateTime::ymd_hms(2300, 1, 1, 0, 0, 0).ticks()), i64::MAX);
        assert_eq!(unix_ns(i64::MIN), i64::MIN);
    }

    #[test]
    fn numbers_take_the_type_of_the_node() {
        assert_eq!(like(&Variant::Double(0.0), 3), Some(Variant::Double(3.0)));
        assert_eq!(like(&Variant::Boolean(false), 1), Some(Variant::Boolean(true)));
        assert_eq!(like(&Variant::Byte(0), 256), None);
        assert_eq!(like(&Variant::Empty, 1), None);
        assert_eq!(number(&Variant::Boolean(true)), Some(1.0));
    }
}
