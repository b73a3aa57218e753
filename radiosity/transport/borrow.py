"""Arrays in compiled code without the reference counts that every view of them would touch."""

from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.extending import intrinsic


@intrinsic
def borrowed(typing, value):
    """Return an array, or a tuple of arrays and numbers, whose views cost no atomic counting.

    Only for arguments of what is called from Python, which keeps the memory alive meanwhile; not
    for arrays that compiled code makes, nor to be returned.
    """
    _check(value)

    def code(context, builder, signature, args):
        return _unowned(context, builder, value, args[0])

    return value(value), code


def _check(kind):
    if isinstance(kind, types.BaseTuple):
        for part in kind.types:
            _check(part)
    elif not isinstance(kind, types.Array | types.Number | types.Boolean):
        raise TypingError(f"only arrays and numbers can be borrowed, not {kind}")


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
