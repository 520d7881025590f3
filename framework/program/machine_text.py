"""LLVM code of a program: a loop over the rows of a batch, and within it one over a few entries at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .program import TABLES, Operation, Program
from .sines import reduced, rotated, splat

# Batch entries in a vector; LLVM splits vectors if the processor's registers are shorter.
WIDTH = 8
# Results of more bytes than this bypass the cache (non-temporal stores), which could not hold them until they are read.
PAST = 2**24
_V, _B = f"<{WIDTH} x double>", f"<{WIDTH} x i1>"
_NAMES = {
    Operation.ADD: "fadd",
    Operation.SUBTRACT: "fsub",
    Operation.MULTIPLY: "fmul",
    Operation.DIVIDE: "fdiv",
    Operation.LESS: "fcmp olt",
    Operation.LESS_EQUAL: "fcmp ole",
}
_LOGIC = {Operation.AND: "and", Operation.OR: "or"}
_BELOW = {Operation.MINIMUM: "olt", Operation.MAXIMUM: "ogt"}
_CALLS = {
    Operation.SQUARE_ROOT: "sqrt",
    Operation.ABSOLUTE: "fabs",
    Operation.MULTIPLY_ADD: "fmuladd",
    Operation.MULTIPLY_SUBTRACT: "fmuladd",
    Operation.SUBTRACT_PRODUCT: "fmuladd",
}
# Index of the operand whose sign is changed in these calls.
_TURNED = {Operation.MULTIPLY_SUBTRACT: 2, Operation.SUBTRACT_PRODUCT: 0}
_DECLARED = "\n".join(
    [
        *(f"declare {_V} @llvm.{name}.v{WIDTH}f64({_V})" for name in ("sqrt", "fabs")),
        *(f"declare {_V} @llvm.{name}.v{WIDTH}f64({_V}, {_V}, {_V})" for name in ("fma", "fmuladd")),
    ]
)
SINES = frozenset({Operation.SINE, Operation.COSINE})


class Text:
    """LLVM code of a kernel.

    Parameters
    ----------
    program
        The program.
    same, read
        Numbers of the input values: those that are the same along a row, stored contiguously, and tables and values
        that vary.
    written
        Numbers of the values that are written to memory.
    """

    def __init__(self, program: Program, same: Sequence[int], read: Sequence[int], written: Sequence[int]) -> None:
        self.program, self.read, self.written = program, read, written
        self.label = "entries"
        self._reduced: set[int] = set()
        self._places: set[int] = set()
        self._same = {k: place for place, k in enumerate(same)}
        self._values = [*same, *(k for k in read if k not in program.tables)]
        self._unread, self._asked = set(self._values), frozenset(written)
        self._past = [k for k in written if not program.holds(k)]

    def lines(self) -> Iterator[str]:
        """All of it."""
        yield _DECLARED
        yield "define void @run(ptr noalias %table, i64 %first, i64 %last, i64 %start, i64 %stop) {"
        yield f"entry:\n  %most = sub i64 %stop, {WIDTH}"
        yield "  %rows = sub i64 %last, %first\n  %columns = sub i64 %stop, %start\n  %size = mul i64 %rows, %columns"
        yield f"  %many = icmp sgt i64 %size, {PAST // (8 * max(1, len(self._past)))}\n  br label %row"
        yield "row:\n  %r = phi i64 [%first, %entry], [%r1, %done]"
        yield from self._begin_row()
        yield "  br label %entries\nentries:\n  %j = phi i64 [%start, %row], [%j1, %next]"
        yield f"  %place = add i64 %j, %begin\n  %off = and i64 %place, {WIDTH - 1}\n  %aligned = icmp eq i64 %off, 0"
        yield "  %whole = and i1 %aligned, %past"
        yield from self._steps()
        yield f"  br label %next\nnext:\n  %behind = add i64 %j, {WIDTH}\n  %over = icmp sge i64 %behind, %stop"
        yield "  %short = select i1 %past, i64 %off, i64 0\n  %j0 = sub i64 %behind, %short"
        yield "  %beyond = icmp sgt i64 %j0, %most"
        yield "  %j1 = select i1 %beyond, i64 %most, i64 %j0\n  br i1 %over, label %done, label %entries"
        yield "done:\n  %r1 = add i64 %r, 1\n  %all = icmp sge i64 %r1, %last\n  br i1 %all, label %end, label %row"
        yield "end:\n  fence seq_cst\n  ret void\n}\n!0 = !{i32 1}"

    # -- memory ------------------------------------------------------------------------------------------------------

    def _begin_row(self) -> Iterator[str]:
        """Load the address of each value, that of the values that do not vary along the row first."""
        yield f"  %at = mul i64 %r, {1 + len(self.read) + len(self.written)}"
        yield "  %line = getelementptr ptr, ptr %table, i64 %at\n  %same = load ptr, ptr %line"
        for place, k in enumerate([*self.read, *self.written], 1):
            yield f"  %l{place} = getelementptr ptr, ptr %line, i64 {place}\n  %p{k} = load ptr, ptr %l{place}"
        yield from self._begin_lines()

    def _begin_lines(self) -> Iterator[str]:
        """Decide whether results bypass the cache: if they are many, and cache lines begin at the same entries of all.

        Such a row then continues, after its first entries, at the beginning of a cache line.
        """
        if not self._past:
            yield "  %begin = add i64 0, 0\n  %past = icmp ne i64 0, 0"
            return
        first, *others = self._past
        yield f"  %q{first} = ptrtoint ptr %p{first} to i64\n  %begin = lshr i64 %q{first}, 3"
        differ = "0"
        for k in others:
            yield f"  %q{k} = ptrtoint ptr %p{k} to i64\n  %x{k} = xor i64 %q{k}, %q{first}"
            yield f"  %y{k} = or i64 {differ}, %x{k}"
            differ = f"%y{k}"
        yield f"  %differ = and i64 {differ}, {8 * WIDTH - 1}\n  %alike = icmp eq i64 %differ, 0"
        yield "  %past = and i1 %alike, %many"

    def _load(self, k: int) -> Iterator[str]:
        if k in self._same:
            yield f"  %b{k} = getelementptr double, ptr %same, i64 {self._same[k]}\n  %c{k} = load double, ptr %b{k}"
            yield from _everywhere(f"%c{k}", f"{self._loaded(k)}")
        else:
            yield f"  %a{k} = getelementptr double, ptr %p{k}, i64 %j"
            yield f"  {self._loaded(k)} = load {_V}, ptr %a{k}, align 8"
        yield from self._condition(k)

    def _loaded(self, k: int) -> str:
        return f"%d{k}" if self.program.holds(k) else f"%v{k}"

    def _condition(self, k: int) -> Iterator[str]:
        """Convert a condition that an earlier step stored in memory, as 1 or 0, to a boolean vector."""
        if self.program.holds(k):
            yield f"  %v{k} = fcmp une {_V} %d{k}, zeroinitializer"

    def _store(self, k: int) -> Iterator[str]:
        if self.program.holds(k):
            yield f"  %z{k} = zext {_B} %v{k} to <{WIDTH} x i8>\n  %w{k} = getelementptr i8, ptr %p{k}, i64 %j"
            yield f"  store <{WIDTH} x i8> %z{k}, ptr %w{k}, align 1"
        else:
            yield f"  %w{k} = getelementptr double, ptr %p{k}, i64 %j"
            if k in self._past:
                yield f"  br i1 %whole, label %far{k}, label %near{k}\nfar{k}:"
                yield f"  store {_V} %v{k}, ptr %w{k}, align {8 * WIDTH}, !nontemporal !0\n  br label %put{k}"
                yield f"near{k}:\n  store {_V} %v{k}, ptr %w{k}, align 8\n  br label %put{k}\nput{k}:"
                self.label = f"put{k}"
            else:
                yield f"  store {_V} %v{k}, ptr %w{k}, align 8"

    # -- steps -------------------------------------------------------------------------------------------------------

    def _steps(self) -> Iterator[str]:
        """The steps before the rounds, the rounds, and the steps after them."""
        program, made = self.program, [k + self.program.first for k in self.program.made(self.program.widest)]
        if program.rounds is None:
            for k in made:
                yield from self._read_for(k)
                yield from self._step(k)
                if k in self._asked:
                    yield from self._store(k)
            return
        for k in self._values:
            yield from self._load(k)
        carried = {begins for begins, _ in program.rounds.carried}
        late = set(carried)
        for k in made:
            if not late.isdisjoint(program.steps[k - program.first].operands):
                late.add(k)
        yield from self._all(k for k in made if k not in late)
        yield from self._rounds([k for k in made if k in program.again and k not in carried])
        yield from self._all(k for k in made if k in late and k not in program.again and k not in carried)
        for k in self.written:
            yield from self._store(k)

    def _read_for(self, k: int) -> Iterator[str]:
        """Load the operands of a step that have not been loaded yet: late loads keep few numbers in registers."""
        for operand in self.program.steps[k - self.program.first].operands:
            if operand in self._unread:
                self._unread.discard(operand)
                yield from self._load(operand)

    def _all(self, those: Iterator[int] | Sequence[int]) -> Iterator[str]:
        for k in those:
            yield from self._step(k)

    def _rounds(self, those: Sequence[int]) -> Iterator[str]:
        rounds, before = self.program.rounds, self.label
        assert rounds is not None
        body = []
        self.label = "again"
        for k in those:
            body += list(self._step(k))
        yield "  br label %again\nagain:"
        yield f"  %round = phi i64 [0, %{before}], [%rounds, %{self.label}]"
        for k, after in rounds.carried:
            begins = self._operand(self.program.steps[k - self.program.first].a)
            kind = _B if self.program.holds(k) else _V
            yield f"  %v{k} = phi {kind} [{begins}, %{before}], [{self._operand(after)}, %{self.label}]"
        yield from body
        yield f"  %left = bitcast {_B} {self._operand(rounds.again)} to i{WIDTH}\n  %some = icmp ne i{WIDTH} %left, 0"
        yield f"  %rounds = add i64 %round, 1\n  %few = icmp slt i64 %rounds, {rounds.most}"
        yield "  %go = and i1 %some, %few\n  br i1 %go, label %again, label %settled\nsettled:"
        self.label = "settled"

    def _step(self, k: int) -> Iterator[str]:
        step = self.program.steps[k - self.program.first]
        operation = step.operation
        if operation in TABLES:
            yield from (self._search if operation == Operation.SEARCH else self._look_up)(k, step.a, step.b)
            return
        a, *others = (self._operand(each) for each in step.operands)
        if operation in _NAMES:
            yield f"  %v{k} = {_NAMES[operation]} {_V} {a}, {others[0]}"
        elif operation in _CALLS:
            if operation in _TURNED:
                operands = [a, *others]
                yield f"  %f{k} = fneg {_V} {operands[_TURNED[operation]]}"
                operands[_TURNED[operation]] = f"%f{k}"
                a, *others = operands
            rest = "".join(f", {_V} {each}" for each in others)
            yield f"  %v{k} = call {_V} @llvm.{_CALLS[operation]}.v{WIDTH}f64({_V} {a}{rest})"
        elif operation in SINES:
            if step.a not in self._reduced:
                self._reduced.add(step.a)
                yield from reduced(a, f"x{step.a}", WIDTH)
            yield from rotated(f"x{step.a}", f"v{k}", WIDTH, cosine=operation == Operation.COSINE)
        elif operation == Operation.NEGATE:
            yield f"  %v{k} = fneg {_V} {a}"
        elif operation in _LOGIC:
            yield f"  %v{k} = {_LOGIC[operation]} {_B} {a}, {others[0]}"
        elif operation == Operation.NOT:
            yield f"  %v{k} = xor {_B} {a}, splat (i1 true)"
        elif operation == Operation.CHOOSE:
            kind = _B if self.program.holds(k) else _V
            yield f"  %v{k} = select {_B} {a}, {kind} {others[0]}, {kind} {others[1]}"
        else:
            # As NumPy's: NaN where one of them is.
            yield f"  %b{k} = fcmp {_BELOW[operation]} {_V} {a}, {others[0]}\n  %n{k} = fcmp uno {_V} {a}, {a}"
            yield f"  %c{k} = or {_B} %b{k}, %n{k}"
            yield f"  %v{k} = select {_B} %c{k}, {_V} {a}, {_V} {others[0]}"

    def _search(self, k: int, table: int, x: int) -> Iterator[str]:
        """Compare each number of the table with all entries, up to the final inf."""
        at, before = f"search{k}", self.label
        yield f"  br label %{at}\n{at}:"
        yield f"  %si{k} = phi i64 [0, %{before}], [%sn{k}, %{at}]"
        yield f"  %sc{k} = phi {_V} [zeroinitializer, %{before}], [%v{k}, %{at}]"
        yield f"  %sp{k} = getelementptr double, ptr %p{table}, i64 %si{k}\n  %st{k} = load double, ptr %sp{k}"
        yield from _everywhere(f"%st{k}", f"%sv{k}")
        yield f"  %sl{k} = fcmp ole {_V} %sv{k}, {self._operand(x)}"
        yield f"  %so{k} = select {_B} %sl{k}, {_V} {splat(1.0)}, {_V} zeroinitializer"
        yield f"  %v{k} = fadd {_V} %sc{k}, %so{k}\n  %sn{k} = add i64 %si{k}, 1"
        yield f"  %sg{k} = fcmp olt double %st{k}, 0x7FF0000000000000"
        yield f"  br i1 %sg{k}, label %{at}, label %found{k}\nfound{k}:"
        self.label = f"found{k}"

    def _look_up(self, k: int, table: int, place: int) -> Iterator[str]:
        if place not in self._places:
            self._places.add(place)
            for entry in range(WIDTH):
                yield f"  %g{place}x{entry} = extractelement {_V} {self._operand(place)}, i64 {entry}"
                yield f"  %i{place}x{entry} = fptosi double %g{place}x{entry} to i64"
        last = "poison"
        for entry in range(WIDTH):
            yield f"  %h{k}x{entry} = getelementptr double, ptr %p{table}, i64 %i{place}x{entry}"
            yield f"  %e{k}x{entry} = load double, ptr %h{k}x{entry}"
            name = f"%v{k}" if entry == WIDTH - 1 else f"%u{k}x{entry}"
            yield f"  {name} = insertelement {_V} {last}, double %e{k}x{entry}, i64 {entry}"
            last = name

    def _operand(self, k: int) -> str:
        program = self.program
        return splat(program.constants[k - program.given]) if program.given <= k < program.first else f"%v{k}"


def _everywhere(scalar: str, vector: str) -> Iterator[str]:
    """Write a vector with a number in all lanes."""
    yield f"  {vector}e = insertelement {_V} poison, double {scalar}, i64 0"
    yield f"  {vector} = shufflevector {_V} {vector}e, {_V} poison, <{WIDTH} x i32> zeroinitializer"
