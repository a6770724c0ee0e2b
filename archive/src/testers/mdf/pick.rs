//! Which channels of a measurement are position, load, time and contact.

use falcon_mdf::model::Channel;
use shared_types::{Axis, Quantity};

use super::super::choice::ColumnChoice;
use super::group::{self, Group, Place, listed};

/// The channels that make a curve.
#[derive(Clone, Copy)]
pub(super) struct Picked<'f> {
    pub(super) axis: Axis,
    pub(super) position: Place<'f>,
    pub(super) load: Place<'f>,
    /// The time as it was chosen, or the master of the position's group.
    pub(super) time: Option<Place<'f>>,
    pub(super) contact: Option<Place<'f>>,
}

impl<'f> Picked<'f> {
    /// The channels of those names, which may have their group's number before them, as in `2/Angle`.
    pub(super) fn by_choice(groups: &[Group<'f>], chosen: &ColumnChoice) -> Result<Self, String> {
        let axis = chosen.axis().ok_or_else(|| super::choice::ChoiceError::Incomplete.to_string())?;
        let words = [axis.position().name(), axis.load().name(), Quantity::Time.name(), "contact"];
        let asked = words.map(|word| chosen.column(word));
        let found = asked.map(|name| {
            name.map(|name| {
                let found = places(groups, |group, channel| {
                    let numbered = || format!("{}/{}", group.number, channel.name.trim());
                    channel.name.trim() == name || numbered() == name
                });
                let missing = || format!("it has no channel `{name}`; it has {}", listed(groups));
                if found.is_empty() { Err(missing()) } else { Ok(found) }
            })
            .transpose()
        });
        let [position, load, time, contact] = found;
        let found = [position?, load?, time?, contact?];
        let [position, load, time, contact] = together(groups, &found)?;
        let (Some(position), Some(load)) = (position, load) else { return Err(unknown(groups)) };
        Ok(Self { axis, position, load, time: time.or_else(|| master(groups, position)), contact })
    }

    /// The channels whose names or units say what they are.
    pub(super) fn by_name_or_unit(groups: &[Group<'f>]) -> Result<Self, String> {
        for axis in [Axis::Rotary, Axis::Linear] {
            let found = [axis.position(), axis.load()].map(|quantity| {
                let is_called = |name: &str| {
                    name.eq_ignore_ascii_case(quantity.name()) || name.eq_ignore_ascii_case(group::own_name(quantity))
                };
                let by_name = places(groups, |_, channel| is_called(channel.name.trim()));
                let by_unit =
                    || places(groups, |_, channel| !channel.is_master() && quantity.factor(&channel.unit).is_some());
                Some(if by_name.is_empty() { by_unit() } else { by_name })
            });
            if found.iter().flatten().any(Vec::is_empty) {
                continue;
            }
            let [position, load] = found;
            if let [Some(position), Some(load), ..] = together(groups, &[position, load, None, None])? {
                return Ok(Self { axis, position, load, time: master(groups, position), contact: None });
            }
        }
        Err(unknown(groups))
    }
}

fn unknown(groups: &[Group<'_>]) -> String {
    format!(
        "it has no unambiguous channels for angle and torque, or travel and force; it has {}; name them, as in \
         --columns angle=NAME,torque=NAME",
        listed(groups)
    )
}

fn master<'f>(groups: &[Group<'f>], position: Place<'f>) -> Option<Place<'f>> {
    groups[position.group].master().map(|channel| Place { channel, ..position })
}

/// Every channel that is one of those wanted.
fn places<'f>(groups: &[Group<'f>], is_wanted: impl Fn(&Group<'f>, &Channel) -> bool) -> Vec<Place<'f>> {
    let all = groups
        .iter()
        .enumerate()
        .flat_map(|(place, group)| group.channels().map(move |channel| (group, Place { group: place, channel })));
    all.filter(|(group, place)| is_wanted(group, place.channel)).map(|(_, place)| place).collect()
}

/// One channel for each quantity: those of the only group that has exactly one of each, or else the only ones in the file.
fn together<'f>(groups: &[Group<'f>], found: &[Option<Vec<Place<'f>>>; 4]) -> Result<[Option<Place<'f>>; 4], String> {
    let of_group = |group: usize| {
        let alone = |places: &Option<Vec<Place<'f>>>| {
            let mut here = places.iter().flatten().filter(|place| place.group == group);
            here.next().filter(|_| here.next().is_none()).copied()
        };
        let picked = found.each_ref().map(alone);
        let is_whole = found.iter().zip(&picked).all(|(places, one)| places.is_some() == one.is_some());
        is_whole.then_some(picked)
    };
    let mut whole = (0..groups.len()).filter_map(of_group);
    match (whole.next(), whole.next()) {
        (Some(picked), None) => return Ok(picked),
        (None, _) if found.iter().flatten().all(|places| places.len() == 1) => {
            return Ok(found.each_ref().map(|places| places.as_ref().and_then(|places| places.first().copied())));
        }
        _ => {}
    }
    let several = found.iter().flatten().find(|places| places.len() > 1);
    let names: Vec<String> = several
        .into_iter()
        .flatten()
        .map(|place| format!("`{}/{}`", groups[place.group].number, place.channel.name.trim()))
        .collect();
    Err(format!(
        "several of its channels match, {}: name one, as in angle=GROUP/NAME,torque=GROUP/NAME",
        names.join(", ")
    ))
}
