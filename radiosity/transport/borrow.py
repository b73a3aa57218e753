"""Arrays in compiled code without the reference counts that every view of them would touch."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def borrowed(typing, value):
    """Return an array, or a tuple of what may be arrays, whose views cost no atomic counting.

    The caller keeps the memory alive while they are used.
    """

    def code(context, builder, signature, args):
        return _unowned(context, builder, value, args[0])

    return value(value), code


def _unowned(context, builder, kind, value):
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = ir.Constant(array.meminfo.type, None)
        array.parent = ir.Constant(array.parent.type, None)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        parts = [
            _unowned(context, builder, part, builder.extract_value(value, k))
            for k, part in enumerate(kind.types)
        ]
        return context.make_tuple(builder, kind, parts)
    return value
