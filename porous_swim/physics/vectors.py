"""Vectors in Taichi scope, of numbers or of lanes.

A block of swimmers moves as one vector instruction does: a value of a step is a wide value, which holds that of each
lane. Taichi compiles arithmetic of wide values (`ti.types.vector(lanes, real)`) to vector instructions of any width
that the processor has, as long as it may keep them whole (`backend.whole_vectors`). It has no vectors in space of wide
values, and neither conversions of wide values between integers and reals nor their bits: these are here.
The same functions take plain numbers for components, where one swimmer is looked at.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from types import SimpleNamespace

from taichi.lang import impl, ops
from taichi.lang.expr import Expr
from taichi.lang.matrix import make_matrix


def for_kernels(function):
    """Let kernels call a Python function of expressions: it runs while they are compiled."""
    function._is_taichi_function = True
    function.func = SimpleNamespace(has_print=False)
    return function


class Vec:
    """A vector whose components are numbers or wide values.

    Products have the vector first: `x * 2.0`. A name is bound once, and another one for the same vector is the same
    vector; a vector that changes is made by `variable`. Components can be assigned, `v[0] = 1.0`.
    """

    _data_oriented = True  # tells Taichi to take it as it is

    def __init__(self, components, *, variable=False):
        self.components = [impl.expr_init(c) for c in components]  # each evaluated once
        self._variable = variable

    @property
    def n(self):
        """Number of components."""
        return len(self.components)

    @for_kernels
    def dot(self, other):
        """Scalar product, added in the order of components."""
        total = self[0] * other[0]
        for a, b in zip(self.components[1:], other.components[1:], strict=True):
            total = total + a * b
        return impl.expr_init(total)

    @for_kernels
    def variable(self):
        """A copy that can be assigned to."""
        return Vec(self.components, variable=True)

    def _each(self, operation, other):
        others = other.components if isinstance(other, Vec) else [other] * self.n
        return Vec([operation(a, b) for a, b in zip(self.components, others, strict=True)])

    def _assign(self, value):
        """Take the components of another vector: what `x = value` means for a name that is bound."""
        if not self._variable:
            raise TypeError("a vector that is not a `variable` is bound once")
        for mine, other in zip(self.components, [impl.expr_init(c) for c in value.components], strict=True):
            mine._assign(other)

    def _augassign(self, value, operation):
        self._assign(self._each(getattr(ops, operation.lower()), value))

    def __getitem__(self, i):
        return self.components[i]

    def __add__(self, other):
        return self._each(ops.add, other)

    def __sub__(self, other):
        return self._each(ops.sub, other)

    def __mul__(self, other):
        return self._each(ops.mul, other)

    def __truediv__(self, other):
        return self._each(ops.truediv, other)


class Record:
    """Named numbers and vectors that are passed and assigned together, `found.near = 3`."""

    _data_oriented = True

    def __init__(self, **fields):
        for name, value in fields.items():
            copy = value.variable() if isinstance(value, Vec) else impl.expr_init(value)
            setattr(self, name, copy)

    @for_kernels
    def but(self, **changes):
        """Another one that differs in some of the fields."""
        return Record(**{**vars(self), **changes})

    def _assign(self, other):
        for name, value in vars(other).items():
            getattr(self, name)._assign(value)


@for_kernels
def record(**fields):
    """A `Record` of these fields."""
    return Record(**fields)


@for_kernels
def vec(*components):
    """A vector of these components."""
    return Vec(components)


@for_kernels
def pick(condition, a, b):
    """`ti.select` for vectors."""
    return Vec([ops.select(condition, x, y) for x, y in zip(a.components, b.components, strict=True)])


@for_kernels
def by_lane(operation, *values):
    """`operation` on numbers or wide values, lane by lane: for what Taichi has for numbers alone, as `ti.pow`."""
    wide = [value for value in values if value.is_tensor()]
    if not wide:
        return operation(*values)
    lanes = range(wide[0].n)
    return make_matrix([operation(*(lane_of(v, j) if v.is_tensor() else v for v in values)) for j in lanes])


@for_kernels
def bit_cast(value, kind):
    """`ti.bit_cast`, also of a wide value: lane by lane, which compiles to nothing."""
    value = impl.expr_init(value)
    if not value.is_tensor():
        return ops.bit_cast(value, kind)
    return make_matrix([ops.bit_cast(lane_of(value, j), kind) for j in range(value.n)])


def lane_of(value: Expr, j: int) -> Expr:
    """The number in lane j of a wide value."""
    return impl.subscript(impl.get_runtime().compiling_callable.ast_builder(), value, j)
