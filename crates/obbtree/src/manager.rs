//! Many named objects in one world.

use crate::batch;
use crate::collider::{Collider, Contact, Nearest};
use crate::engine::geometry::rigid;
use crate::mesh::power_of_two;
use crate::pair::Pair;
use crate::pose::{self, PoseError};
use crate::world::{self, Bounds, Item};
use nalgebra::Isometry3;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Named colliders with poses in one world, and the pairs of them that are not asked about.
///
/// Objects are rigid; several may share one [`Collider`]. Answers name objects in the order of their names, and points are in the frame of the world.
/// All meshes must have the same unit.
///
/// ```
/// use obbtree::{Collider, Manager, Mesh};
/// use obbtree::nalgebra::Isometry3;
///
/// let plate = Collider::new(Mesh::new([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0, 1, 2]])?);
/// let mut cell = Manager::new();
/// cell.insert("table", plate.clone(), Isometry3::identity())?;
/// cell.insert("part", plate.clone(), Isometry3::translation(0.0, 0.0, 2.0))?;
/// assert_eq!(cell.nearest()?.unwrap().nearest.distance, 2.0);
/// cell.set_pose("part", Isometry3::identity())?;
/// assert_eq!(cell.colliding_pairs(), [["part", "table"]]);
/// cell.ignore("table", "part");
/// assert!(!cell.collides());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Manager {
    objects: BTreeMap<String, Object>,
    /// Names, the first before the second.
    ignored: BTreeMap<String, BTreeSet<String>>,
}

#[derive(Clone, Debug)]
struct Object {
    collider: Collider,
    world_from_object: Isometry3<f64>,
}

/// The nearest points of two objects.
#[derive(Clone, Debug, PartialEq)]
pub struct NearestObjects<'a> {
    /// The names of the objects.
    pub names: [&'a str; 2],
    /// Their distance, and their nearest points in the frame of the world.
    pub nearest: Nearest,
}

/// Where two objects touch.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectContacts<'a> {
    /// The names of the objects.
    pub names: [&'a str; 2],
    /// Their triangles that touch, with points in the frame of the world.
    pub contacts: Vec<Contact>,
}

/// Why a manager cannot do as asked.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ManagerError {
    /// No object has the name.
    NoSuchObject(String),
    /// The pose of an object cannot be used.
    Pose {
        /// The name of the object.
        name: String,
        /// What is wrong with its pose.
        error: PoseError,
    },
    /// A pose of a row of an array of poses cannot be used.
    PoseInRow {
        /// The number of the row.
        row: usize,
        /// The name of the object.
        name: String,
        /// What is wrong with its pose.
        error: PoseError,
    },
    /// A name is given twice: an object has one pose in a row.
    NamedTwice(String),
    /// A row of an array of poses does not have as many poses as there are names.
    WrongLength {
        /// The number of the row.
        row: usize,
        /// How many poses it has.
        poses: usize,
        /// How many names there are.
        names: usize,
    },
}

impl fmt::Display for ManagerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchObject(name) => write!(f, "no object `{name}` in the manager"),
            Self::Pose { name, error } => write!(f, "object `{name}`: {error}"),
            Self::PoseInRow { row, name, error } => write!(f, "row {row}, object `{name}`: {error}"),
            Self::NamedTwice(name) => write!(f, "object `{name}` is named twice: a row has one pose for each object"),
            Self::WrongLength { row, poses, names } => write!(f, "row {row} has {poses} poses for {names} objects"),
        }
    }
}

impl std::error::Error for ManagerError {}

impl Manager {
    /// A manager without objects.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an object at a pose, which takes its coordinates to those of the world. An object of the same name is replaced.
    ///
    /// # Errors
    /// [`ManagerError::Pose`] when the pose is not finite, has no rotation, or has a translation beyond 2¹⁰⁰⁰, about 10³⁰¹, on an axis.
    pub fn insert(
        &mut self,
        name: impl Into<String>,
        collider: Collider,
        world_from_object: Isometry3<f64>,
    ) -> Result<(), ManagerError> {
        let name = name.into();
        let world_from_object = checked(&world_from_object).map_err(|error| of_object(&name, error))?;
        self.objects.insert(name, Object { collider, world_from_object });
        Ok(())
    }

    /// Takes an object out. Ignored pairs with its name stay ignored, also for a later object of that name.
    ///
    /// # Errors
    /// [`ManagerError::NoSuchObject`].
    pub fn remove(&mut self, name: &str) -> Result<Collider, ManagerError> {
        let removed = self.objects.remove(name).map(|object| object.collider);
        removed.ok_or_else(|| ManagerError::NoSuchObject(name.to_owned()))
    }

    /// Moves an object.
    ///
    /// # Errors
    /// [`ManagerError::NoSuchObject`], or [`ManagerError::Pose`] as [`Manager::insert`].
    pub fn set_pose(&mut self, name: &str, world_from_object: Isometry3<f64>) -> Result<(), ManagerError> {
        let object = self.objects.get_mut(name).ok_or_else(|| ManagerError::NoSuchObject(name.to_owned()))?;
        object.world_from_object = checked(&world_from_object).map_err(|error| of_object(name, error))?;
        Ok(())
    }

    /// Stops asking about a pair of objects, by their names in any order. There need not be such objects yet.
    pub fn ignore(&mut self, name: &str, other: &str) {
        let (first, second) = (name.min(other), name.max(other));
        self.ignored.entry(first.to_owned()).or_default().insert(second.to_owned());
    }

    /// Asks about an ignored pair again.
    pub fn consider(&mut self, name: &str, other: &str) {
        if let Some(ignored) = self.ignored.get_mut(name.min(other)) {
            ignored.remove(name.max(other));
        }
    }

    /// Whether a pair, by its names in any order, is ignored.
    #[must_use]
    pub fn is_ignored(&self, name: &str, other: &str) -> bool {
        self.ignored.get(name.min(other)).is_some_and(|ignored| ignored.contains(name.max(other)))
    }

    /// The collider and the pose of an object.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<(&Collider, &Isometry3<f64>)> {
        self.objects.get(name).map(|object| (&object.collider, &object.world_from_object))
    }

    /// The names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.objects.keys().map(String::as_str)
    }

    /// How many objects there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Whether there is no object.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// Whether any pair of objects touches, but those ignored.
    #[must_use]
    pub fn collides(&self) -> bool {
        self.any_touch(&self.items())
    }

    /// The pairs of objects that touch, but those ignored.
    #[must_use]
    pub fn colliding_pairs(&self) -> Vec<[&str; 2]> {
        let items = self.items();
        let touching = self.pairs(&items, 0.0).into_iter().filter(|&(i, j)| touch(&items[i], &items[j]));
        touching.map(|(i, j)| [items[i].name, items[j].name]).collect()
    }

    /// The triangles that touch of each pair of objects, but those ignored: at most `limit` of a pair.
    #[must_use]
    pub fn contacts(&self, limit: usize) -> Vec<ObjectContacts<'_>> {
        let items = self.items();
        let pairs = self.pairs(&items, 0.0);
        pairs.into_iter().filter_map(|(i, j)| contacts(&items[i], &items[j], limit)).collect()
    }

    /// The pairs of objects, but those ignored, whose boxes along the axes of the world are at most `reach` apart: what is left to ask about in detail. None where
    /// `reach` is NaN.
    #[must_use]
    pub fn near_pairs(&self, reach: f64) -> Vec<[&str; 2]> {
        let items = self.items();
        self.pairs(&items, reach).into_iter().map(|(i, j)| [items[i].name, items[j].name]).collect()
    }

    /// The nearest pair of objects, but those ignored; `None` where there is no pair.
    ///
    /// # Errors
    /// As [`Collider::distance`]; no pose that a manager takes is too far.
    pub fn nearest(&self) -> Result<Option<NearestObjects<'_>>, PoseError> {
        let items = self.items();
        let least = world::least_gap(&items, |i, j| !self.is_ignored(items[i].name, items[j].name));
        nearest(|reach| self.pairs(&items, reach), least, &items, &items)
    }

    /// The object that is nearest to a given one, whose name comes first; pairs that are ignored do not count. `None` where there is no other.
    ///
    /// # Errors
    /// [`ManagerError::NoSuchObject`], or [`ManagerError::Pose`] as [`Collider::distance`]; no pose that a manager takes is too far.
    pub fn nearest_to(&self, name: &str) -> Result<Option<NearestObjects<'_>>, ManagerError> {
        let (own, others): (Vec<Item>, Vec<Item>) = self.items().into_iter().partition(|item| item.name == name);
        if own.is_empty() {
            return Err(ManagerError::NoSuchObject(name.to_owned()));
        }
        let wanted = |j: usize| !self.is_ignored(name, others[j].name);
        let pairs = |reach| {
            let mut pairs = world::near_between(&own, &others, reach);
            pairs.retain(|&(_, j)| wanted(j));
            pairs
        };
        let least = world::least_gap_between(&own, &others, |_, j| wanted(j));
        nearest(pairs, least, &own, &others).map_err(|error| of_object(name, error))
    }

    /// Whether any object touches one of another manager, which has the same world. Nothing is ignored.
    #[must_use]
    pub fn collides_with(&self, other: &Self) -> bool {
        let (ours, theirs) = (self.items(), other.items());
        world::near_between(&ours, &theirs, 0.0).into_iter().any(|(i, j)| touch(&ours[i], &theirs[j]))
    }

    /// The pairs (object, object of another manager) that touch.
    #[must_use]
    pub fn colliding_pairs_with<'a>(&'a self, other: &'a Self) -> Vec<[&'a str; 2]> {
        let (ours, theirs) = (self.items(), other.items());
        let pairs = world::near_between(&ours, &theirs, 0.0).into_iter();
        pairs.filter(|&(i, j)| touch(&ours[i], &theirs[j])).map(|(i, j)| [ours[i].name, theirs[j].name]).collect()
    }

    /// The triangles that touch of each pair (object, object of another manager): at most `limit` of a pair.
    #[must_use]
    pub fn contacts_with<'a>(&'a self, other: &'a Self, limit: usize) -> Vec<ObjectContacts<'a>> {
        let (ours, theirs) = (self.items(), other.items());
        let pairs = world::near_between(&ours, &theirs, 0.0).into_iter();
        pairs.filter_map(|(i, j)| contacts(&ours[i], &theirs[j], limit)).collect()
    }

    /// [`Manager::near_pairs`] of (object, object of another manager).
    #[must_use]
    pub fn near_pairs_with<'a>(&'a self, other: &'a Self, reach: f64) -> Vec<[&'a str; 2]> {
        let (ours, theirs) = (self.items(), other.items());
        let pairs = world::near_between(&ours, &theirs, reach).into_iter();
        pairs.map(|(i, j)| [ours[i].name, theirs[j].name]).collect()
    }

    /// The nearest pair (object, object of another manager); `None` where either is empty.
    ///
    /// # Errors
    /// As [`Collider::distance`]; no pose that a manager takes is too far.
    pub fn nearest_with<'a>(&'a self, other: &'a Self) -> Result<Option<NearestObjects<'a>>, PoseError> {
        let (ours, theirs) = (self.items(), other.items());
        let least = world::least_gap_between(&ours, &theirs, |_, _| true);
        nearest(|reach| world::near_between(&ours, &theirs, reach), least, &ours, &theirs)
    }

    /// [`Manager::collides`] at many places of some objects, on as many threads as there are. Each row of `poses` has a pose for each of `names`; other
    /// objects stay where they are.
    ///
    /// ```
    /// use obbtree::{Collider, Manager, Mesh};
    /// use obbtree::nalgebra::Isometry3;
    ///
    /// let plate = Collider::new(Mesh::new([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0, 1, 2]])?);
    /// let mut cell = Manager::new();
    /// cell.insert("table", plate.clone(), Isometry3::identity())?;
    /// cell.insert("part", plate.clone(), Isometry3::identity())?;
    /// let heights = [0.0, 0.5, -0.0].map(|z| [Isometry3::translation(0.0, 0.0, z)]);
    /// assert_eq!(cell.collides_each(&["part"], &heights)?, [true, false, true]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ManagerError::NoSuchObject`], [`ManagerError::NamedTwice`], [`ManagerError::WrongLength`], or [`ManagerError::PoseInRow`] for the first pose that
    /// [`Manager::insert`] would refuse.
    pub fn collides_each<R: AsRef<[Isometry3<f64>]> + Sync>(
        &self,
        names: &[&str],
        poses: &[R],
    ) -> Result<Vec<bool>, ManagerError> {
        let items = self.items();
        let place = |name: &&str| items.binary_search_by_key(name, |item| item.name);
        let places: Vec<usize> = names
            .iter()
            .map(|name| place(name).map_err(|_| ManagerError::NoSuchObject((*name).to_owned())))
            .collect::<Result<_, _>>()?;
        let mut named = BTreeSet::new();
        if let Some(twice) = names.iter().find(|name| !named.insert(**name)) {
            return Err(ManagerError::NamedTwice((*twice).to_owned()));
        }
        for (row, poses) in poses.iter().map(AsRef::as_ref).enumerate() {
            if poses.len() != names.len() {
                return Err(ManagerError::WrongLength { row, poses: poses.len(), names: names.len() });
            }
            for (name, pose) in names.iter().zip(poses) {
                checked(pose).map_err(|error| ManagerError::PoseInRow { row, name: (*name).to_owned(), error })?;
            }
        }
        self.make_trees(&items, &places, poses);
        let verdict = |row: &R| {
            let mut moved = items.clone();
            for (&place, pose) in places.iter().zip(row.as_ref()) {
                let Item { name, collider, .. } = moved[place];
                moved[place] = Item::new(name, collider, rigid::rigid(pose));
            }
            self.any_touch(&moved)
        };
        Ok(batch::map(poses, verdict))
    }

    /// The objects, in the order of their names.
    fn items(&self) -> Vec<Item<'_>> {
        self.objects.iter().map(|(name, object)| Item::new(name, &object.collider, object.world_from_object)).collect()
    }

    /// Makes the trees that pairs of different size may ask for at some row of poses: threads that missed one at a time would each make it.
    fn make_trees<R: AsRef<[Isometry3<f64>]>>(&self, items: &[Item], places: &[usize], poses: &[R]) {
        let exponent = |item: &Item| item.collider.frame().exponent;
        if poses.is_empty() || items.iter().all(|item| exponent(item) == exponent(&items[0])) {
            return;
        }
        // Each object with a box around it that holds at all rows.
        let mut swept = items.to_vec();
        for (k, &place) in places.iter().enumerate() {
            let collider = items[place].collider;
            let bounds = poses.iter().map(|row| Bounds::new(collider, &rigid::rigid(&row.as_ref()[k])));
            swept[place].bounds = bounds.reduce(Bounds::joined).expect("there is a row");
        }
        for (i, j) in self.pairs(&swept, 0.0) {
            if exponent(&items[i]) != exponent(&items[j]) {
                Pair::new(items[i].collider, items[j].collider);
            }
        }
    }

    fn any_touch(&self, items: &[Item]) -> bool {
        self.pairs(items, 0.0).into_iter().any(|(i, j)| touch(&items[i], &items[j]))
    }

    /// Pairs of objects whose bounds are no more than `reach` apart, but those ignored.
    fn pairs(&self, items: &[Item], reach: f64) -> Vec<(usize, usize)> {
        let mut pairs = world::near(items, reach);
        pairs.retain(|&(i, j)| !self.is_ignored(items[i].name, items[j].name));
        pairs
    }
}

/// A pose that is finite, rigid, and not so far away that the way between two of them is not finite.
fn checked(pose: &Isometry3<f64>) -> Result<Isometry3<f64>, PoseError> {
    const LIMIT: f64 = power_of_two(1000);
    let pose = pose::checked(pose)?;
    if pose.translation.vector.amax() <= LIMIT { Ok(pose) } else { Err(PoseError::TooFar { limit: LIMIT }) }
}

fn of_object(name: &str, error: PoseError) -> ManagerError {
    ManagerError::Pose { name: name.to_owned(), error }
}

/// The pair's frame is that of the first.
fn first_from_second(a: &Item, b: &Item) -> Isometry3<f64> {
    a.pose.inv_mul(&b.pose)
}

fn touch(a: &Item, b: &Item) -> bool {
    Pair::new(a.collider, b.collider).collides(&first_from_second(a, b)) == Ok(true)
}

fn contacts<'a>(a: &Item<'a>, b: &Item<'a>, limit: usize) -> Option<ObjectContacts<'a>> {
    let mut contacts = Pair::new(a.collider, b.collider).contacts(&first_from_second(a, b), limit).ok()?;
    contacts.iter_mut().for_each(|contact| contact.point = a.pose * contact.point);
    (!contacts.is_empty()).then_some(ObjectContacts { names: [a.name, b.name], contacts })
}

/// The nearest of the pairs that `pairs` gives for a reach: those whose bounds are no farther apart. `least` is the least gap of their bounds, `None`
/// where there is no pair.
///
/// The reach grows by steps from there to the least distance that is known: few pairs wait at a time, and none is measured twice.
fn nearest<'a>(
    pairs: impl Fn(f64) -> Vec<(usize, usize)>,
    least: Option<f64>,
    ours: &[Item<'a>],
    theirs: &[Item<'a>],
) -> Result<Option<NearestObjects<'a>>, PoseError> {
    let Some(mut reach) = least else { return Ok(None) };
    let first_step = median_size(ours, theirs) / 16.0;
    let mut best: Option<NearestObjects<'a>> = None;
    let mut measured = f64::NEG_INFINITY;
    loop {
        let gap = |(i, j): (usize, usize)| ours[i].bounds.gap(&theirs[j].bounds);
        let found = pairs(reach).into_iter().map(|pair| (gap(pair), pair));
        let mut found: Vec<(f64, (usize, usize))> = found.filter(|(gap, _)| *gap > measured).collect();
        found.sort_by(|x, y| x.0.total_cmp(&y.0));
        for (gap, (i, j)) in found {
            let below = best.as_ref().map_or(f64::INFINITY, |best| best.nearest.distance);
            if gap >= below {
                break;
            }
            let (a, b) = (&ours[i], &theirs[j]);
            let pair = Pair::new(a.collider, b.collider).distance_below(&first_from_second(a, b), below)?;
            if let Some(mut nearest) = pair {
                nearest.points = nearest.points.map(|p| a.pose * p);
                best = Some(NearestObjects { names: [a.name, b.name], nearest });
            }
        }
        let known = best.as_ref().map_or(f64::INFINITY, |best| best.nearest.distance);
        if reach >= known {
            return Ok(best);
        }
        measured = reach;
        let next = (2.0 * reach).max(first_step);
        reach = if next > reach { next.min(known) } else { known };
    }
}

/// The median of the longest edges of the bounds.
fn median_size(ours: &[Item], theirs: &[Item]) -> f64 {
    let mut sizes: Vec<f64> = ours.iter().chain(theirs).map(|item| item.bounds.size()).collect();
    let middle = sizes.len() / 2;
    *sizes.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests;
