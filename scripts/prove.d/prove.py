"""Instantiates the templates of proofs/ with the constants of the engine's source, and has Gappa prove them.

A template is a Gappa script with a head of comments:

    # proves: WHAT                         a line for the table
    # constant: FILE NAME | MEANING        a constant of the source, or of proofs/steps.txt; in one template with what it means
    # constant: FILE NAME as 1 - x         the same, but x is what is made smaller
    # constant: FILE NAME by /PATTERN/     a number in the code that has no name; the pattern finds it exactly once
    # code: FILE FUNCTION                  what the proof is about; proofs/code.txt keeps a hash of it
    # variants: fused unfused              both ways of rounding a product and a sum

and in its body `@NAME@` for a constant, `@NAME:k@` for it times 2^-k, `rounded32(n)` and `rounded64(n)` for n roundings, (1 + e1)...(1 + en) with fresh |e| <= u, whose bounds
`@ROUNDINGS@` becomes; `fma32(a, b, c)` for a b + c and `nfma32(a, b, c)` for c - a b, rounded once or twice by the variant.
"""

import ast
import fractions
import hashlib
import pathlib
import re
import shutil
import struct
import subprocess
import sys
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[2]
ENGINE = ROOT / "crates/obbtree/src/engine"
PROOFS = ROOT / "proofs"
STEPS = PROOFS / "steps.txt"
CODE = PROOFS / "code.txt"
# A constant that is so much larger than what is proved that a tenth of it still holds, and why.
GENEROUS = PROOFS / "generous.txt"
# The slowest proof takes a third of a second; what is not proved after this counts as not proved.
TIMEOUT_S = 20
# The same where a constant has been made smaller, to see how far that goes.
TIMEOUT_SMALLER_S = 4


class Fault(Exception):
    """What is wrong, for the user."""


# ---- the source ----


def single(number: float) -> float:
    """The nearest f32."""
    return struct.unpack("f", struct.pack("f", number))[0]


def sources() -> dict[str, pathlib.Path]:
    """The engine's files by name; those of the same name in two folders need the folder: `geometry/mod.rs`."""
    found: dict[str, list[pathlib.Path]] = {}
    for path in sorted(ENGINE.rglob("*.rs")):
        found.setdefault(path.name, []).append(path)
    return {name: paths[0] for name, paths in found.items() if len(paths) == 1}


class Source:
    """The engine's constants and functions."""

    def __init__(self) -> None:
        self.files = sources()
        self.texts = {name: path.read_text() for name, path in self.files.items()}

    def text(self, file: str) -> str:
        if file not in self.texts:
            raise Fault(f"there is no file {file} in {ENGINE.relative_to(ROOT)}: has it been renamed? mend the heads in proofs/")
        return self.texts[file]

    def constant(self, file: str, name: str) -> float:
        """The value of `const NAME: f64 = EXPRESSION;`, by the arithmetic of its type."""
        text = self.text(file)
        found = re.findall(rf"\bconst {name}: (f32|f64) = ([^;]+);", text)
        if len(found) != 1:
            raise Fault(f"{file} has {len(found)} constants {name}, not one: has it been renamed? mend the heads in proofs/")
        kind, expression = found[0]
        return self.value(expression, kind, file)

    def value(self, expression: str, kind: str, file: str) -> float:
        """An expression of numbers, names of constants, + - * / and brackets."""
        expression = re.sub(r"(?<=\d)_(?=\d)", "", expression)
        expression = re.sub(r"\b(\w+)::", "", expression)
        rounded = single if kind == "f32" else float

        def of(node: ast.expr) -> float:
            match node:
                case ast.Constant(value=(int() | float()) as number):
                    return rounded(float(number))
                case ast.Name(id=name):
                    homes = [f for f, text in self.texts.items() if re.search(rf"\bconst {name}: f(32|64) = ", text)]
                    home = file if file in homes else homes[0] if len(homes) == 1 else None
                    if home is None:
                        raise Fault(f"{file}: which constant {name} is meant? {len(homes)} files have one")
                    return self.constant(home, name)
                case ast.UnaryOp(op=ast.USub(), operand=operand):
                    return -of(operand)
                case ast.BinOp(left=left, op=op, right=right):
                    one, other = of(left), of(right)
                    match op:
                        case ast.Add():
                            return rounded(one + other)
                        case ast.Sub():
                            return rounded(one - other)
                        case ast.Mult():
                            return rounded(one * other)
                        case ast.Div():
                            return rounded(one / other)
            raise Fault(f"{file}: `{expression}` is more than numbers, names and + - * /")

        return of(ast.parse(expression.strip(), mode="eval").body)

    def number(self, file: str, name: str, pattern: str) -> float:
        """A number that has no name."""
        found = re.findall(pattern, self.text(file))
        if len(found) != 1:
            raise Fault(f"{file}: the pattern of {name}, /{pattern}/, is found {len(found)} times, not once: mend the heads in proofs/")
        return float(found[0])

    def function(self, file: str, name: str) -> str:
        """The text of a function, of its impl where `Type::name` says so, without comments and blanks."""
        text = self.text(file).split("#[cfg(test)]\nmod tests")[0]
        text = re.sub(r"//[^\n]*", "", text)
        of, _, bare = name.rpartition("::")
        if of:
            start = re.search(rf"\bimpl(<[^{{]*>)? {of}\b", text)
            if start is None:
                raise Fault(f"{file} has no impl of {of}: mend the heads in proofs/")
            text = text[start.start() :]
        start = re.search(rf"\bfn {bare}\b", text)
        if start is None:
            raise Fault(f"{file} has no function {name}: has it been renamed? mend the heads in proofs/")
        depth, body = 0, text[start.start() :]
        for end, letter in enumerate(body):
            depth += (letter == "{") - (letter == "}")
            if letter == "}" and depth == 0:
                return re.sub(r"\s+", "", body[: end + 1])
        raise Fault(f"{file}: the function {name} does not end")


# ---- the templates ----


@dataclass
class Constant:
    """A constant that a proof is about."""

    file: str
    name: str
    value: float
    one_minus: bool = False
    meaning: str = ""

    def scaled(self, factor: float) -> float:
        """With what it allows made smaller."""
        return 1 - (1 - self.value) * factor if self.one_minus else self.value * factor

    @property
    def allowed(self) -> float:
        return 1 - self.value if self.one_minus else self.value


@dataclass
class Template:
    """A script with its head read."""

    path: pathlib.Path
    proves: str = ""
    constants: list[Constant] = field(default_factory=list)
    code: list[tuple[str, str]] = field(default_factory=list)
    variants: list[str] = field(default_factory=lambda: ["unfused"])
    body: str = ""


def steps() -> dict[str, tuple[float, str]]:
    """The bounds that proofs hand on, and where they come from."""
    found = {}
    for line in STEPS.read_text().splitlines():
        if line and not line.startswith("#"):
            name, number, where = line.split(maxsplit=2)
            found[name] = (float(number), where)
    return found


def read(path: pathlib.Path, source: Source) -> Template:
    template = Template(path)
    for line in path.read_text().splitlines():
        head = re.match(r"# (proves|constant|code|variants): (.*)", line)
        if not head:
            template.body += line + "\n"
            continue
        kind, text = head.groups()
        if kind == "proves":
            template.proves = text
        elif kind == "variants":
            template.variants = text.split()
        elif kind == "code":
            file, function = text.split()
            template.code.append((file, function))
        else:
            text, _, meaning = text.partition(" | ")
            found = re.fullmatch(r"(\S+) (\w+)(?: (as 1 - x)|(?: by /(.*)/))?", text)
            if found is None:
                raise Fault(f"{path.name}: `{line}` is not FILE NAME [as 1 - x | by /PATTERN/]")
            file, name, one_minus, pattern = found.groups()
            if file == STEPS.name:
                if name not in steps():
                    raise Fault(f"{path.name}: {STEPS.name} has no step {name}")
                value = steps()[name][0]
            elif pattern:
                value = source.number(file, name, pattern)
            else:
                value = source.constant(file, name)
            template.constants.append(Constant(file, name, value, bool(one_minus), meaning))
    if not template.proves:
        raise Fault(f"{path.name} does not say what it proves: it needs a line `# proves: ...`")
    return template


def exact(number: float) -> str:
    """A number as Gappa reads it, to the last bit: m 2^e."""
    top, bottom = fractions.Fraction(number).as_integer_ratio()
    return f"{top}b-{bottom.bit_length() - 1}" if bottom > 1 else str(top)


def arguments(text: str, start: int) -> tuple[list[str], int]:
    """What stands between brackets, the first of which is at `start`, by commas; and where it ends."""
    depth, parts, last = 0, [], start + 1
    for at in range(start, len(text)):
        depth += (text[at] == "(") - (text[at] == ")")
        if depth == 0:
            return [*parts, text[last:at]], at + 1
        if text[at] == "," and depth == 1:
            parts.append(text[last:at])
            last = at + 1
    raise Fault(f"a bracket is not closed: {text[start:]}")


def expanded(text: str, variant: str) -> str:
    """With `fma32` and `nfma32` written out."""
    while found := re.search(r"\b(n?)fma32\(", text):
        (a, b, c), end = arguments(text, found.end() - 1)
        product = f"({a}) * ({b})" if variant == "fused" else f"float<ieee_32,ne>(({a}) * ({b}))"
        total = f"({c}) - {product}" if found[1] else f"{product} + ({c})"
        text = text[: found.start()] + f"float<ieee_32,ne>({total})" + text[end:]
    return text


def instance(template: Template, variant: str, source: Source, scaled: dict[str, float]) -> str:
    """The script with every constant in its place; those in `scaled` times a factor."""
    own = {constant.name: constant for constant in template.constants}
    bounds: list[str] = []

    def rounded(found: re.Match[str]) -> str:
        unit = {"32": "1b-24", "64": "1b-53"}[found[1]]
        names = [f"e{len(bounds) + k}" for k in range(int(found[2]))]
        bounds.extend(f"|{name}| <= {unit}" for name in names)
        return "(" + " * ".join(f"(1 + {name})" for name in names) + ")"

    def constant(found: re.Match[str]) -> str:
        name, half = found[1], 0.5 ** int(found[2] or 0)
        if name in own:
            return exact(own[name].scaled(scaled.get(name, 1.0)) * half)
        if name in steps():
            return exact(steps()[name][0] * half)
        homes = [file for file, text in source.texts.items() if re.search(rf"\bconst {name}: f(32|64) = ", text)]
        if len(homes) != 1:
            raise Fault(f"{template.path.name}: @{name}@ is in {len(homes)} files; name it in a line `# constant: ...`")
        return exact(source.constant(homes[0], name) * half)

    body = re.sub(r"rounded(32|64)\((\d+)\)", rounded, template.body)
    body = body.replace("@ROUNDINGS@", " /\\ ".join(bounds))
    body = re.sub(r"@([A-Z_]+)(?::(\d+))?@", constant, body)
    return expanded(body, variant)


def proved(script: str, timeout_s: float) -> tuple[bool, str]:
    """Whether Gappa proves it, and what it says."""
    try:
        done = subprocess.run(["gappa"], input=script, capture_output=True, text=True, timeout=timeout_s, check=False)
    except subprocess.TimeoutExpired:
        return False, f"no proof within {timeout_s} s"
    text = done.stderr + done.stdout
    if "syntax error" in text or "Error: undefined" in text:
        raise Fault(f"Gappa cannot read a script: {text.strip()}")
    # Only a run that ends well, without a warning, has proved all there is.
    return done.returncode == 0 and not text.strip(), text.strip()


def holds(template: Template, source: Source, scaled: dict[str, float]) -> tuple[bool, str]:
    """Whether all variants are proved."""
    for variant in template.variants:
        is_proved, text = proved(instance(template, variant, source, scaled), TIMEOUT_SMALLER_S if scaled else TIMEOUT_S)
        if not is_proved:
            return False, f"{template.path.name} ({variant}): {text}"
    return True, ""


# ---- what is asked ----


def code(templates: list[Template], source: Source) -> dict[str, str]:
    """A hash of every function that a proof is about."""
    hashes = {}
    for file, function in sorted({place for template in templates for place in template.code}):
        hashes[f"{file} {function}"] = hashlib.sha256(source.function(file, function).encode()).hexdigest()[:16]
    return hashes


def accept(templates: list[Template], source: Source) -> None:
    lines = [f"{place} {mark}" for place, mark in code(templates, source).items()]
    head = "# What the proofs are about, by hash. A change here asks for a look at the proof; then `scripts/prove --accept`.\n"
    CODE.write_text(head + "\n".join(lines) + "\n")


def changed(templates: list[Template], source: Source) -> list[str]:
    """Functions that are not what they were when their proof was last looked at."""
    kept = {}
    if CODE.exists():
        for line in CODE.read_text().splitlines():
            if not line.startswith("#"):
                place, mark = line.rsplit(" ", 1)
                kept[place] = mark
    now = code(templates, source)
    return [place for place in now if kept.get(place) != now[place]]


def least(templates: list[Template], source: Source, constant: Constant) -> float:
    """The smallest factor of a constant with which everything about it is still proved, within a fiftieth."""
    about = [t for t in templates if any(same(c, constant) for c in t.constants)]

    def enough(factor: float) -> bool:
        return all(holds(template, source, {constant.name: factor})[0] for template in about)

    low, high = 0.0, 1.0
    step = 0.5
    while step > 1e-8 and enough(step):
        high, step = step, step / 2
    low = step
    while high > 1.02 * low:
        middle = (low + high) / 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def same(one: Constant, other: Constant) -> bool:
    return (one.file, one.name) == (other.file, other.name)


def all_constants(templates: list[Template]) -> list[Constant]:
    found: list[Constant] = []
    for template in templates:
        found.extend(c for c in template.constants if not any(same(c, known) for known in found))
    return found


def generous() -> dict[str, str]:
    """Constants of which a tenth is still enough, with the reason."""
    lines = GENEROUS.read_text().splitlines()
    return dict(line.split(" ", 1) for line in lines if line and not line.startswith("#"))


def table(templates: list[Template], source: Source) -> None:
    """What each constant is, what is proved to be needed, and how much larger it is."""
    print(f"{'constant':<38} {'value':>12} {'proved':>12} {'slack':>9}  meaning")
    for constant in all_constants(templates):
        factor = least(templates, source, constant)
        meaning = next((c.meaning for t in templates for c in t.constants if same(c, constant) and c.meaning), "")
        place = f"{constant.file} {constant.name}"
        print(f"{place:<38} {constant.allowed:>12.5g} {constant.allowed * factor:>12.5g} {1 / factor:>9.3g}  {meaning}")


def self_test(templates: list[Template], source: Source) -> int:
    """Makes each constant ten times smaller: a proof must fail, but for those that say why not. A constant that is not there must be an error."""
    failures, excused = 0, generous()
    for constant in all_constants(templates):
        about = [t for t in templates if any(same(c, constant) for c in t.constants)]
        # What is larger than it needs to be must fail where it is made smaller still.
        factor = 1.0 if constant.name not in excused else 1e-9
        factor *= 0.1
        caught = [t.path.name for t in about if not holds(t, source, {constant.name: factor})[0]]
        still_enough = constant.name in excused and all(holds(t, source, {constant.name: 0.1})[0] for t in about)
        if constant.name in excused and not still_enough:
            print(f"FAILED: {constant.name} is in {GENEROUS.name}, but a tenth of it is not enough: take it out")
            failures += 1
        verdict = "its proof fails" if caught else "STILL PROVED"
        print(f"{constant.file} {constant.name} x {factor:g}: {verdict} {', '.join(caught)}")
        failures += not caught
    for wrong, text in [
        ("a renamed constant", "# proves: x\n# constant: volume.rs PER_DISTANCES\n"),
        ("a file that is not there", "# proves: x\n# constant: volumes.rs PER_DISTANCE\n"),
        ("a pattern that is not found", "# proves: x\n# constant: visit.rs X by /no such thing ([0-9]+)/\n"),
    ]:
        path = ROOT / "target" / "prove" / "wrong.gappa"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        try:
            read(path, source)
        except Fault as fault:
            print(f"{wrong}: refused: {fault}")
        else:
            print(f"FAILED: {wrong} is taken")
            failures += 1
    # A function that has changed must be seen.
    known = dict(source.texts)
    file, function = templates[0].code[0]
    source.texts[file] = re.sub(rf"(\bfn {function.rpartition('::')[2]}\b[^{{]*{{)", r"\1 let changed = 1;", known[file])
    if f"{file} {function}" not in changed(templates, source):
        print(f"FAILED: a change of {file} {function} is not seen")
        failures += 1
    else:
        print(f"a change of {file} {function}: seen")
    source.texts = known
    print(f"{failures} failures" if failures else "all constants are needed")
    return 1 if failures else 0


def main(asked: list[str]) -> int:
    if shutil.which("gappa") is None:
        print("scripts/prove: gappa is not installed", file=sys.stderr)
        return 3
    source = Source()
    templates = [read(path, source) for path in sorted(PROOFS.glob("*.gappa"))]
    match asked:
        case ["--accept"]:
            accept(templates, source)
            return 0
        case ["--table"]:
            table(templates, source)
            return 0
        case ["--self-test"]:
            return self_test(templates, source)
        case ["--show", name]:
            for template in templates:
                if template.path.name == name:
                    for variant in template.variants:
                        print(instance(template, variant, source, {}))
            return 0
        case []:
            pass
        case _:
            raise Fault(f"unknown option {' '.join(asked)}; see --help")
    failures = 0
    for template in templates:
        is_proved, text = holds(template, source, {})
        print(f"{'proved' if is_proved else 'FAILED'}  {template.path.name}: {template.proves}")
        if not is_proved:
            print(f"        {text}")
            failures += 1
    for place in changed(templates, source):
        print(f"CHANGED {place}: see whether its proof still says what the code does, then run `scripts/prove --accept`")
        failures += 1
    print(f"{len(templates) - failures} of {len(templates)} proved" if not failures else f"{failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Fault as fault:
        print(f"scripts/prove: {fault}", file=sys.stderr)
        sys.exit(2)
