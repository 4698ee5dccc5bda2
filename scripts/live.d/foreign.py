"""The watch against a server of asyncua, and the simulated control against a client of asyncua.

asyncua shares no code with async-opcua. Usage: foreign.py BVBENCH-LIVE WORK-FOLDER. Exit 1 when a check fails.
"""

import asyncio
import csv
import shutil
import socket
import sys
from datetime import datetime, timedelta, timezone
from pathlib import Path

from asyncua import Client, Server, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography.x509.oid import ExtendedKeyUsageOID

HERE = Path(__file__).resolve().parent
AXIS = "ns=2;s=/Channel/MachineAxis/actToolBasePos[u1,{}]"
VERDICT, HOLD, HEARTBEAT = (f"ns=2;s=/Channel/Parameter/R[u1,{i}]" for i in (900, 901, 902))
CLEAR = 1
CYCLE_S, DEADLINE_S, PATIENCE_S = 0.02, 0.15, 60.0
ACCELERATION = 50.0  # mm/s²


def check(what: str, holds: bool) -> None:
    """Says what was checked, and ends when it does not hold."""
    print(("ok    " if holds else "FAILED") + "  " + what, flush=True)
    if not holds:
        sys.exit(1)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def configuration(folder: Path, name: str, port: int, more: str = "", line: bool = True) -> Path:
    """The configuration beside this script with another port."""
    text = (HERE / "live.toml").read_text().replace(":4841/", f":{port}/")
    text = text.replace("cycle_ms = 4", f"cycle_ms = {CYCLE_S * 1000}").replace("deadline_ms = 40", f"deadline_ms = {DEADLINE_S * 1000}")
    text = text.replace("acceleration = 1000", f"acceleration = {ACCELERATION}").replace("stale_ms = 200", "stale_ms = 20000")
    if not line:
        text = text.replace('line = "ns=2;s=/Channel/ProgramInfo/actLineNumber"', "")
    path = folder / name
    path.write_text(text + more)
    return path


async def start(program: str, *arguments: object) -> asyncio.subprocess.Process:
    return await asyncio.create_subprocess_exec(program, *map(str, arguments))


async def stop(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        process.terminate()
    await process.wait()


class Mill:
    """A server of asyncua whose Z goes down at a constant speed until it is held, then brakes."""

    SPEED = 10.0  # mm/s

    async def open(self, port: int) -> None:
        self.server = Server()
        await self.server.init()
        self.server.set_endpoint(f"opc.tcp://127.0.0.1:{port}/")
        self.server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        index = await self.server.register_namespace("urn:bvbench:foreign")
        assert index == 2, index
        objects = self.server.nodes.objects
        add = lambda node, value, kind: objects.add_variable(ua.NodeId.from_string(node), node, value, kind)
        self.axes = [await add(AXIS.format(i), 0.0, ua.VariantType.Double) for i in (1, 2, 3)]
        self.verdict = await add(VERDICT, 0, ua.VariantType.Int32)
        self.hold = await add(HOLD, True, ua.VariantType.Boolean)
        self.heartbeat = await add(HEARTBEAT, 0, ua.VariantType.Int32)
        for node in (self.verdict, self.hold, self.heartbeat):
            await node.set_writable()
        await self.server.start()

    async def permits(self, now: datetime) -> bool:
        """Whether the newest verdict is about a sample within the deadline, permits, and the hold is off."""
        verdict = await self.verdict.read_data_value()
        stamp = verdict.SourceTimestamp
        if await self.hold.read_value() or verdict.Value.Value not in (1, 2) or stamp is None:
            return False
        stamp = stamp if stamp.tzinfo else stamp.replace(tzinfo=timezone.utc)
        return (now - stamp).total_seconds() + CYCLE_S <= DEADLINE_S

    async def run(self, until_held: bool) -> tuple[float, bool]:
        """Goes down from Z 260 over the jaw; returns where it stands, and whether it ever moved."""
        z, share, moved, stands_s = 260.0, 0.0, False, 0.0
        now, fall = datetime.now(timezone.utc), None
        for _ in range(int(PATIENCE_S / CYCLE_S)):
            now += timedelta(seconds=CYCLE_S)
            if await self.permits(now):
                share, fall, stands_s = min(1.0, share + 0.3 * ACCELERATION * CYCLE_S / self.SPEED), None, 0.0
            else:
                fall = fall or ACCELERATION / self.SPEED
                share = max(0.0, share - fall * CYCLE_S)
                stands_s += CYCLE_S
            z -= self.SPEED * share * CYCLE_S
            moved |= share > 0.0
            for node, value in zip(self.axes, (80.0, 28.0, z)):
                value = ua.DataValue(ua.Variant(value, ua.VariantType.Double), SourceTimestamp=now, ServerTimestamp=datetime.now(timezone.utc))
                await node.write_value(value)
            if moved and stands_s > (3.0 if until_held else 1e9):
                return z, moved
            await asyncio.sleep(CYCLE_S)
        return z, moved


async def foreign_server(program: str, folder: Path) -> None:
    """Our watch on their server."""
    port, log = free_port(), folder / "asyncua-server.csv"
    log.unlink(missing_ok=True)  # a watch writes behind what is there
    mill = Mill()
    await mill.open(port)
    watch = await start(program, "watch", configuration(folder, "asyncua-server.toml", port, line=False), "--log", log)
    try:
        z, moved = await mill.run(until_held=True)
    finally:
        await stop(watch)
        await mill.server.stop()
    rows = list(csv.DictReader(log.open()))
    check("asyncua's server: the mill moved on our verdicts", moved)
    held = [row for row in rows if row["fault"] == "contact"]
    check("asyncua's server: our watch held it for " + (held[0]["pair"] if held else "nothing"), bool(held) and "holder" in held[0]["pair"])
    last = rows[-1]
    proof = f"it stands at Z {z:.2f} with {float(last['clearance_mm']):.2f} mm guaranteed to {last['pair'] or 'anything in sight'}"
    check("asyncua's server: " + proof, last["verdict"] in ("clear", "near") and float(last["clearance_mm"]) > 0.0)


async def client(url: str, folder: Path, name: str) -> Client:
    """A client of asyncua with a certificate of its own."""
    key, certificate = folder / f"{name}.pem", folder / f"{name}.der"
    uri = f"urn:bvbench:foreign:{name}"
    subject = {"countryName": "DE", "stateOrProvinceName": "-", "localityName": "-", "organizationName": name}
    await setup_self_signed_certificate(key, certificate, uri, "127.0.0.1", [ExtendedKeyUsageOID.CLIENT_AUTH], subject)
    found = Client(url, timeout=20)
    found.application_uri = uri
    found.set_user("watch")
    found.set_password("sesame")
    await found.set_security(SecurityPolicyBasic256Sha256, str(certificate), str(key), mode=ua.MessageSecurityMode.SignAndEncrypt)
    return found


async def connects(who: Client) -> bool:
    try:
        await who.connect()
        return True
    except (ua.UaError, ConnectionError, asyncio.TimeoutError, OSError):
        return False


async def wait_for_port(port: int) -> None:
    for _ in range(600):
        try:
            _, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.close()
            return
        except OSError:
            await asyncio.sleep(0.1)
    check("the simulated control listens", False)


async def foreign_client(program: str, folder: Path) -> None:
    """Their client on our control."""
    port = free_port()
    (folder / "password").write_text("sesame\n")
    security = '\n[security]\npolicy = "Basic256Sha256"\nmode = "SignAndEncrypt"\nuser = "watch"\npassword_file = "password"\npki = "control-pki"\ncreate_certificate = true\n'
    shutil.rmtree(folder / "control-pki", ignore_errors=True)
    config = configuration(folder, "asyncua-client.toml", port, security)
    control = await start(program, "control", config, HERE / "clear.ngc", "--repeat")
    try:
        await wait_for_port(port)
        url = f"opc.tcp://127.0.0.1:{port}/"
        check("asyncua's client: an unknown certificate is refused", not await connects(await client(url, folder, "friend")))
        rejected = list((folder / "control-pki/rejected").glob("*.der"))
        check("asyncua's client: it lies in rejected/ for the administrator", len(rejected) == 1)
        shutil.move(rejected[0], folder / "control-pki/trusted" / rejected[0].name)
        friend = Client(url, timeout=20)
        friend.application_uri = "urn:bvbench:foreign:friend"
        friend.set_user("watch")
        friend.set_password("sesame")
        await friend.set_security(
            SecurityPolicyBasic256Sha256, str(folder / "friend.der"), str(folder / "friend.pem"), mode=ua.MessageSecurityMode.SignAndEncrypt
        )
        check("asyncua's client: once trusted it is let in", await connects(friend))
        await play(friend)
        await friend.disconnect()
    finally:
        await stop(control)


async def play(friend: Client) -> None:
    """Writes where it may and may not, and permits motion for a while."""
    axes = [friend.get_node(AXIS.format(i)) for i in (1, 2, 3)]
    verdict, hold = friend.get_node(VERDICT), friend.get_node(HOLD)
    try:
        await axes[0].write_value(ua.DataValue(ua.Variant(1.0, ua.VariantType.Double)))
        refused = False
    except ua.UaStatusCodeError:
        refused = True
    check("asyncua's client: a write to an axis is refused", refused)
    where = [await axis.read_value() for axis in axes]
    check("asyncua's client: without a verdict the machine stands", where == [await axis.read_value() for axis in axes])
    await hold.write_value(ua.DataValue(ua.Variant(False, ua.VariantType.Boolean)))
    for _ in range(200):
        stamp = (await axes[0].read_data_value()).SourceTimestamp
        await verdict.write_value(ua.DataValue(ua.Variant(CLEAR, ua.VariantType.Int32), SourceTimestamp=stamp))
        await asyncio.sleep(0.01)
    there = [await axis.read_value() for axis in axes]
    check("asyncua's client: verdicts about fresh samples let it move", there != where)
    await asyncio.sleep(DEADLINE_S + 3.0)
    where = [await axis.read_value() for axis in axes]
    await asyncio.sleep(0.5)
    check("asyncua's client: without verdicts it stands again", where == [await axis.read_value() for axis in axes])


async def main() -> None:
    program, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    await foreign_server(program, folder)
    await foreign_client(program, folder)


asyncio.run(main())
