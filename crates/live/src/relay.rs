//! A bad network between control and watch: a relay on the loopback address that delays, and loses what TCP then sends again.
//!
//! A lost segment reaches a receiver of TCP as a delay, because it is sent again after the retransmission timeout, and everything behind it
//! waits. The relay does that to each piece that it reads.

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::time::Instant;

/// Least retransmission timeout of TCP in Linux (`TCP_RTO_MIN`).
pub const RETRANSMISSION: Duration = Duration::from_millis(200);
/// Pieces that are under way before the sender has to wait.
const PIECES: usize = 4096;
/// Longest piece, bytes: the payload of a segment on Ethernet.
const PIECE: usize = 1448;

/// Delay and loss between the two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Network {
    /// Delay of every piece, each way.
    pub delay: Duration,
    /// Share of the pieces that are lost.
    pub loss: f64,
    /// Seed of what is lost.
    pub seed: u64,
}

impl Network {
    /// Whether there is any delay or loss.
    pub fn is_bad(&self) -> bool {
        self.loss > 0.0 || !self.delay.is_zero()
    }
}

/// Relays connections to `control` without end.
pub async fn serve(listener: TcpListener, control: SocketAddr, network: Network) {
    let mut seed = network.seed;
    while let Ok((near, _)) = listener.accept().await {
        // A control that is down: the watch sees its connection closed, and tries again.
        let Ok(far) = TcpStream::connect(control).await else { continue };
        for stream in [&near, &far] {
            stream.set_nodelay(true).ok();
        }
        let ((near_in, near_out), (far_in, far_out)) = (near.into_split(), far.into_split());
        for (from, to) in [(near_in, far_out), (far_in, near_out)] {
            seed += 1;
            tokio::spawn(one_way(from, to, Network { seed, ..network }));
        }
    }
}

async fn one_way(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, network: Network) {
    let (sender, mut pieces) = mpsc::channel::<(Instant, Vec<u8>)>(PIECES);
    tokio::spawn(async move {
        while let Some((due, piece)) = pieces.recv().await {
            tokio::time::sleep_until(due).await;
            if to.write_all(&piece).await.is_err() {
                return;
            }
        }
    });
    let mut random = Pcg64Mcg::seed_from_u64(network.seed);
    let mut piece = vec![0; PIECE];
    while let Ok(length @ 1..) = from.read(&mut piece).await {
        let lost = random.random::<f64>() < network.loss;
        let due = Instant::now() + network.delay + if lost { RETRANSMISSION } else { Duration::ZERO };
        if sender.send((due, piece[..length].to_vec())).await.is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn everything_arrives_in_order_and_not_before_its_delay() {
        let far = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let near = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let (near_address, far_address) = (near.local_addr().unwrap(), far.local_addr().unwrap());
        let network = Network { delay: Duration::from_millis(20), loss: 0.2, seed: 1 };
        tokio::spawn(serve(near, far_address, network));
        let sent: Vec<u8> = (0..20_000_u32).map(|i| (i % 251) as u8).collect();
        let begin = Instant::now();
        let mut client = TcpStream::connect(near_address).await.unwrap();
        client.write_all(&sent).await.unwrap();
        client.shutdown().await.unwrap();
        let (mut server, _) = far.accept().await.unwrap();
        let mut received = vec![0; sent.len()];
        server.read_exact(&mut received).await.unwrap();
        assert!(received == sent && begin.elapsed() >= network.delay + RETRANSMISSION, "{:?}", begin.elapsed());
    }
}
