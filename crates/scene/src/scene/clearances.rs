//! How near two parts may come before `check` tells of it: for all pairs, and for parts and roles by name.

use super::{Pair, Part, Role};
use std::str::FromStr;

/// A clearance that is told of when a pair comes nearer. Reads `5`, `holder=5` and `holder:vise=5`.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// What the pair must consist of: none, one, or two parts, each by its name or its role.
    of: Vec<String>,
    /// mm; 0 for nothing at all.
    mm: f64,
}

impl FromStr for Clearance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (of, mm) = text.rsplit_once('=').map_or((None, text), |(of, mm)| (Some(of), mm));
        let of: Vec<String> = of.iter().flat_map(|of| of.split(':')).map(|name| name.trim().to_owned()).collect();
        if of.len() > 2 || of.iter().any(String::is_empty) {
            return Err(format!(
                "`{text}` is no clearance; write 5, NAME=5 or NAME:NAME=5, each NAME a part or a role"
            ));
        }
        let mm: f64 = mm.trim().parse().map_err(|_| format!("`{}` is no number of mm", mm.trim()))?;
        if !(0.0..=Self::LARGEST_MM).contains(&mm) {
            return Err(format!("{mm} is no clearance; it must be a number from 0 to {:e} mm", Self::LARGEST_MM));
        }
        Ok(Self { of, mm })
    }
}

impl Clearance {
    const LARGEST_MM: f64 = rs274::interpret::FARTHEST;

    /// Refuses a name that neither a part nor a role has, and says which there are.
    ///
    /// # Errors
    /// The message.
    pub fn check_names(&self, parts: &[Part]) -> Result<(), String> {
        let (parts, roles) = (parts.iter().map(|part| part.name.as_str()), Role::ALL.iter().map(|role| role.name()));
        let is_unknown = |name: &&String| !parts.clone().chain(roles.clone()).any(|known| known == name.as_str());
        let Some(name) = self.of.iter().find(is_unknown) else { return Ok(()) };
        let [parts, roles] = [parts.collect::<Vec<_>>(), roles.collect()].map(|names| names.join(", "));
        Err(format!("there is no part and no role `{name}`; parts: {parts}; roles: {roles}"))
    }

    /// How closely it describes a pair: how many names it gives, and how many of them are names of parts; `None` when it is about others.
    fn fit(&self, pair: [&Part; 2]) -> Option<(usize, usize)> {
        let fit = |pair: [&Part; 2]| {
            let mut by_name = 0;
            for (name, part) in self.of.iter().zip(pair) {
                let is_name = part.name == *name;
                if !is_name && part.role.name() != name {
                    return None;
                }
                by_name += usize::from(is_name);
            }
            Some((self.of.len(), by_name))
        };
        fit(pair).max(fit([pair[1], pair[0]]))
    }
}

/// The clearances of a scene or of a check. What describes a pair most closely holds for it: two names before one, one before none, and the names of
/// parts before those of roles. Of equally close ones all hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearances(Vec<Clearance>);

impl Clearances {
    /// The paper's zones, mm.
    pub const STANDARD_MM: [f64; 3] = [14.0, 8.0, 2.0];

    /// These; and for pairs that none of them is about, the paper's zones.
    pub fn new(mut clearances: Vec<Clearance>) -> Self {
        if clearances.iter().all(|clearance| !clearance.of.is_empty()) {
            clearances.extend(Self::everywhere(&Self::STANDARD_MM).0);
        }
        Self(clearances)
    }

    /// The same for all pairs, mm; none at all when there are no numbers.
    pub fn everywhere(mm: &[f64]) -> Self {
        Self(mm.iter().map(|&mm| Clearance { of: Vec::new(), mm }).collect())
    }

    /// The clearances of a pair, widest first, mm; empty for none.
    pub fn of(&self, parts: &[Part], pair: Pair) -> Vec<f64> {
        let pair = [&parts[pair.a], &parts[pair.b]];
        let closest = self.0.iter().filter_map(|clearance| clearance.fit(pair)).max();
        let holds = |clearance: &&Clearance| clearance.fit(pair) == closest;
        let mut zones: Vec<f64> = self.0.iter().filter(holds).map(|clearance| clearance.mm).collect();
        zones.retain(|&zone| zone > 0.0);
        zones.sort_by(|a, b| b.total_cmp(a));
        zones.dedup();
        zones
    }

    /// The widest of a pair, mm; 0 for none.
    pub fn widest_mm(&self, parts: &[Part], pair: Pair) -> f64 {
        self.of(parts, pair).first().copied().unwrap_or_default()
    }
}

impl Default for Clearances {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// Clearances of a pair of the scene `mill-vise` by what is asked.
    fn zones(asked: &[&str], names: [&str; 2]) -> Vec<f64> {
        let scene = Scene::find("mill-vise").unwrap();
        let part = |name| scene.parts.iter().position(|part| part.name == name).unwrap();
        let clearances: Vec<Clearance> = asked.iter().map(|text| text.parse().unwrap()).collect();
        clearances.iter().for_each(|clearance| clearance.check_names(&scene.parts).unwrap());
        let clearances = Clearances::new(clearances);
        clearances.of(&scene.parts, Pair { a: part(names[0]), b: part(names[1]) })
    }

    #[test]
    fn the_closest_description_of_a_pair_holds() {
        let all = ["3", "holder=5", "holder:fixture=4", "holder=6"];
        assert_eq!(zones(&[], ["holder", "vise"]), Clearances::STANDARD_MM);
        assert_eq!(zones(&["holder=5"], ["end-mill", "vise"]), Clearances::STANDARD_MM);
        assert_eq!(zones(&all, ["end-mill", "vise"]), [3.0]);
        assert_eq!(zones(&all, ["vise", "holder"]), [4.0]);
        assert_eq!(zones(&all, ["holder", "workpiece"]), [6.0, 5.0]);
        assert_eq!(zones(&["fixture=9", "vise=1"], ["vise", "end-mill"]), [1.0]);
        assert_eq!(zones(&["holder=0"], ["vise", "holder"]), [0.0; 0]);
        assert_eq!(zones(&["0"], ["vise", "holder"]), [0.0; 0]);
    }

    #[test]
    fn what_is_no_clearance_is_refused() {
        for text in ["", "-1", "nan", "inf", "1e300", "holder=", "=5", "a:b:c=5", "a:=5", "holder"] {
            assert!(text.parse::<Clearance>().is_err(), "{text}");
        }
        let scene = Scene::find("mill-vise").unwrap();
        let wrong = "holdr:vise=5".parse::<Clearance>().unwrap().check_names(&scene.parts).unwrap_err();
        assert!(wrong.contains("`holdr`") && wrong.contains("vise") && wrong.contains("fixture"), "{wrong}");
    }
}
