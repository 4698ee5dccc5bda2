//! The values that the watch writes to a control: hold, verdict and heartbeat.
//!
//! The hold comes first in every write and before every verdict, and one that fails does not keep the others back.

use crate::judge::Verdict;
use crate::monitor::Fault;
use crate::opc;
use opcua::client::Session;
use opcua::types::{AttributeId, DataValue, DateTime, NodeId, NumericRange, StatusCode, Variant, WriteValue};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest number that tells a hold.
pub(crate) const MOST_HOLD: u32 = 1;
/// Largest number that tells a verdict.
pub(crate) const MOST_VERDICT: u32 = Verdict::Collision as u32;
/// Largest number of a heartbeat: seven bits fit into every type of a number.
pub(crate) const MOST_BEAT: u32 = 0x7f;

/// A node that takes numbers, and a value of its type.
pub(crate) type Target = (NodeId, Variant);

/// How a hold is given.
pub(crate) enum Way {
    /// By a node, with every verdict: another client may have written it.
    Node(Target),
    /// By a method of an object, when the hold changes.
    Method(NodeId, NodeId),
}

/// The services that the outputs need.
pub(crate) trait Services {
    /// Writes values; a status code for each.
    async fn write(&self, values: &[WriteValue]) -> Result<Vec<StatusCode>, String>;
    /// Calls a method of an object with one argument.
    async fn call(&self, object: &NodeId, method: &NodeId, hold: bool) -> Result<StatusCode, String>;
}

impl Services for Arc<Session> {
    async fn write(&self, values: &[WriteValue]) -> Result<Vec<StatusCode>, String> {
        Session::write(self, values).await.map_err(|error| error.to_string())
    }

    async fn call(&self, object: &NodeId, method: &NodeId, hold: bool) -> Result<StatusCode, String> {
        let call = (object.clone(), method.clone(), Some(vec![Variant::Boolean(hold)]));
        self.call_one(call).await.map(|result| result.status_code).map_err(|error| error.to_string())
    }
}

/// The values that are written together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output {
    /// Whether the machine is held.
    pub hold: bool,
    /// Whether the hold may differ from the one written last.
    pub hold_changes: bool,
    /// The verdict.
    pub verdict: Verdict,
    /// Source time of the sample that the verdict is about, ticks; 0 without one.
    pub source_ticks: i64,
    /// The heartbeat; `None` leaves it as it is.
    pub beat: Option<u32>,
}

/// The nodes that are written.
pub(crate) struct Outputs {
    verdict: Target,
    heartbeat: Option<Target>,
    hold: Way,
    /// Whether the control takes values with source times.
    stamps: AtomicBool,
}

impl Outputs {
    pub fn new(verdict: Target, heartbeat: Option<Target>, hold: Way) -> Self {
        Self { verdict, heartbeat, hold, stamps: AtomicBool::new(true) }
    }

    /// Writes an output; the hold first.
    ///
    /// # Errors
    /// [`Fault::Lost`] without an answer, [`Fault::Node`] when a node does not take its value. What could be written is.
    pub async fn write(&self, services: &impl Services, output: &Output) -> Result<(), Fault> {
        let called = match &self.hold {
            Way::Method(object, method) if output.hold_changes => {
                match services.call(object, method, output.hold).await {
                    Ok(status) if status.is_good() => Ok(()),
                    Ok(status) => Err(Fault::Node(format!("method {method} cannot be called: {status}"))),
                    Err(error) => Err(Fault::Lost(error)),
                }
            }
            _ => Ok(()),
        };
        let written = self.write_nodes(services, output).await;
        called.and(written)
    }

    async fn write_nodes(&self, services: &impl Services, output: &Output) -> Result<(), Fault> {
        let (mut writes, mut results) = self.send(services, output).await?;
        let refuses_times = results.contains(&StatusCode::BadWriteNotSupported) && self.stamps.load(Ordering::Relaxed);
        if refuses_times && self.heartbeat.is_some() {
            // The control need not see source times: the heartbeat tells it that verdicts come.
            self.stamps.store(false, Ordering::Relaxed);
            (writes, results) = self.send(services, output).await?;
        }
        let Some((write, status)) = writes.iter().zip(&results).find(|(_, status)| !status.is_good()) else {
            return Ok(());
        };
        let advice = if refuses_times && self.heartbeat.is_none() {
            "; a control that takes no source times needs `nodes.heartbeat`"
        } else {
            ""
        };
        Err(Fault::Node(format!("node {} cannot be written: {status}{advice}", write.node_id)))
    }

    async fn send(
        &self,
        services: &impl Services,
        output: &Output,
    ) -> Result<(Vec<WriteValue>, Vec<StatusCode>), Fault> {
        let writes = self.values(output);
        let results = services.write(&writes).await.map_err(Fault::Lost)?;
        Ok((writes, results))
    }

    /// The values of an output, the hold first.
    fn values(&self, output: &Output) -> Vec<WriteValue> {
        let has_stamp = output.source_ticks != 0 && self.stamps.load(Ordering::Relaxed);
        let stamp = has_stamp.then(|| opc::date(output.source_ticks));
        let hold = match &self.hold {
            Way::Node(node) => Some(value(node, output.hold.into(), None)),
            Way::Method(..) => None,
        };
        let verdict = value(&self.verdict, output.verdict as u32, stamp);
        let beat = self.heartbeat.as_ref().zip(output.beat).map(|(node, beat)| value(node, beat & MOST_BEAT, stamp));
        hold.into_iter().chain([verdict]).chain(beat).collect()
    }
}

fn value((node_id, template): &Target, number: u32, source_timestamp: Option<DateTime>) -> WriteValue {
    let value = DataValue { value: opc::like(template, number), source_timestamp, ..DataValue::null() };
    let (node_id, attribute_id) = (node_id.clone(), AttributeId::Value as u32);
    WriteValue { node_id, attribute_id, index_range: NumericRange::None, value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    const PERMITS: Output =
        Output { hold: false, hold_changes: true, verdict: Verdict::Clear, source_ticks: 5, beat: Some(1) };
    const HOLDS: Output = Output { hold: true, verdict: Verdict::Collision, ..PERMITS };

    /// A control that notes what it is asked, and refuses some of it.
    #[derive(Default)]
    struct Control {
        asked: Mutex<Vec<String>>,
        refuses_verdicts: bool,
        refuses_times: bool,
        refuses_calls: bool,
    }

    impl Control {
        /// What was asked since the last time.
        fn asked(&self) -> String {
            std::mem::take(&mut *self.asked.lock().unwrap()).join(" ")
        }
    }

    impl Services for Control {
        async fn write(&self, values: &[WriteValue]) -> Result<Vec<StatusCode>, String> {
            let answer = |write: &WriteValue| {
                let is_stamped = write.value.source_timestamp.is_some();
                let number = write.value.value.as_ref().and_then(opc::number).unwrap();
                let stamp = if is_stamped { "@" } else { "" };
                self.asked.lock().unwrap().push(format!("{}={number}{stamp}", write.node_id.identifier));
                match write.node_id.identifier.to_string().as_str() {
                    "s=verdict" if self.refuses_verdicts => StatusCode::BadNotWritable,
                    _ if is_stamped && self.refuses_times => StatusCode::BadWriteNotSupported,
                    _ => StatusCode::Good,
                }
            };
            Ok(values.iter().map(answer).collect())
        }

        async fn call(&self, _object: &NodeId, _method: &NodeId, hold: bool) -> Result<StatusCode, String> {
            self.asked.lock().unwrap().push(format!("call={hold}"));
            if self.refuses_calls { Err("no answer".to_owned()) } else { Ok(StatusCode::Good) }
        }
    }

    fn outputs(hold: Way, has_heartbeat: bool) -> Outputs {
        let target = |name: &str| (NodeId::new(2, name.to_owned()), Variant::Int32(0));
        Outputs::new(target("verdict"), has_heartbeat.then(|| target("beat")), hold)
    }

    fn node() -> Way {
        Way::Node((NodeId::new(2, "hold".to_owned()), Variant::Boolean(false)))
    }

    fn method() -> Way {
        Way::Method(NodeId::new(2, 1), NodeId::new(2, 2))
    }

    #[test]
    fn a_type_that_takes_the_largest_number_tells_all_numbers_apart() {
        let numbers =
            [Variant::SByte(0), Variant::Byte(0), Variant::Int16(0), Variant::Float(0.0), Variant::Double(0.0)];
        for most in [MOST_HOLD, MOST_VERDICT, MOST_BEAT] {
            let told = |template: &Variant, number: u32| opc::like(template, number).as_ref().and_then(opc::number);
            for template in &numbers {
                for number in 0..=most {
                    assert_eq!(told(template, number), Some(f64::from(number)), "{template:?}");
                }
            }
            let hold = (most == MOST_HOLD).then_some(1.0);
            assert_eq!(told(&Variant::Boolean(false), most), hold, "a Boolean tells the hold alone");
        }
    }

    #[tokio::test]
    async fn every_write_begins_with_the_hold() {
        let (control, outputs) = (Control::default(), outputs(node(), true));
        for (output, expected) in [
            (HOLDS, "s=hold=1 s=verdict=3@ s=beat=1@"),
            (Output { hold_changes: false, ..HOLDS }, "s=hold=1 s=verdict=3@ s=beat=1@"),
            (Output { beat: None, hold_changes: false, ..PERMITS }, "s=hold=0 s=verdict=1@"),
        ] {
            outputs.write(&control, &output).await.unwrap();
            assert_eq!(control.asked(), expected);
        }
    }

    #[tokio::test]
    async fn a_hold_by_method_comes_before_the_verdict_and_whatever_fails() {
        let outputs = outputs(method(), false);
        let control = Control { refuses_verdicts: true, ..Control::default() };
        let failed = outputs.write(&control, &HOLDS).await.unwrap_err();
        assert_eq!((failed.name(), control.asked().as_str()), ("node", "call=true s=verdict=3@"));
        let control = Control { refuses_calls: true, ..Control::default() };
        assert_eq!(outputs.write(&control, &HOLDS).await, Err(Fault::Lost("no answer".to_owned())));
        assert_eq!(control.asked(), "call=true s=verdict=3@");
        let control = Control::default();
        outputs.write(&control, &Output { hold_changes: false, ..HOLDS }).await.unwrap();
        assert_eq!(control.asked(), "s=verdict=3@");
    }

    #[tokio::test]
    async fn a_control_that_takes_no_source_times_gets_none_when_it_has_a_heartbeat() {
        let control = Control { refuses_times: true, ..Control::default() };
        let beats = outputs(node(), true);
        beats.write(&control, &PERMITS).await.unwrap();
        assert_eq!(control.asked(), "s=hold=0 s=verdict=1@ s=beat=1@ s=hold=0 s=verdict=1 s=beat=1");
        beats.write(&control, &PERMITS).await.unwrap();
        assert_eq!(control.asked(), "s=hold=0 s=verdict=1 s=beat=1");
        let failed = outputs(node(), false).write(&control, &PERMITS).await.unwrap_err();
        assert!(failed.to_string().contains("needs `nodes.heartbeat`"), "{failed}");
    }
}
