"""Types of the columns that the data dictionary describes."""

from typing import Final

# Names and short texts, the same in all tables. Everything else is a number, or unknown and left to pandas.
TEXT: Final = frozenset(
    {
        "scene", "workload", "pair", "part", "case", "variant", "split", "split_axes", "stratum", "band", "label", "kind", "duplicate_of", "program",
        "ends_at", "baseline", "baseline_policy", "policy", "metric", "effect", "claim", "role", "reading", "measure", "note", "engine", "mode",
        "reference", "view", "binary", "host",
    }
)  # fmt: skip

# Flags, by table: the same name is a count in another table (`exact` of verification) or a text (`verdict` of claims).
FLAGS: Final[dict[str, frozenset[str]]] = {
    "cases": frozenset({"safe", "default", "asked_everywhere"}),
    "poses": frozenset({"exact", "contained"}),
    "answers": frozenset({"verdict"}),
    "verification": frozenset({"safe"}),
    "ratios": frozenset({"noisy"}),
    "peer-answers": frozenset({"exact", "grazing", "touching"}),
}

# Texts in these tables alone.
TEXT_OF: Final[dict[str, frozenset[str]]] = {"claims": frozenset({"verdict"})}

# Whole numbers that may be empty, beside every column that holds whole numbers only.
COUNTS: Final = frozenset({"missed", "baseline_missed", "queries", "clusters", "contacts"})


def text_columns(table: str) -> frozenset[str]:
    """Columns of a table that hold text."""
    return TEXT | TEXT_OF.get(table, frozenset())


def flag_columns(table: str) -> frozenset[str]:
    """Columns of a table that are 0 or 1."""
    return FLAGS.get(table, frozenset())
