"""Writes small ONNX networks for tests: convolutions with a sigmoid behind them. The format is protobuf, and the few messages
that are needed are put together here octet by octet (field numbers from onnx.proto, ONNX 1.12)."""

import numpy

FLOAT = 1  # TensorProto.DataType
SIDE_PX = 128


def varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes(out) + bytes([value])


def number(field: int, value: int) -> bytes:
    return varint(field << 3) + varint(value)


def octets(field: int, value: bytes | str) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return varint(field << 3 | 2) + varint(len(data)) + data


def tensor(name: str, values: numpy.ndarray) -> bytes:
    """TensorProto: dims 1, data_type 2, name 8, raw_data 9."""
    return b"".join(number(1, side) for side in values.shape) + number(2, FLOAT) + octets(8, name) \
        + octets(9, values.astype("<f4").tobytes())


def integers(name: str, values: list[int]) -> bytes:
    """AttributeProto: name 1, ints 8, type 20 (INTS = 7)."""
    return octets(1, name) + b"".join(number(8, value) for value in values) + number(20, 7)


def node(kind: str, inputs: list[str], output: str, attributes: list[bytes] = ()) -> bytes:
    """NodeProto: input 1, output 2, op_type 4, attribute 5."""
    return b"".join(octets(1, one) for one in inputs) + octets(2, output) + octets(4, kind) \
        + b"".join(octets(5, one) for one in attributes)


def value_info(name: str, shape: list[int]) -> bytes:
    """ValueInfoProto: name 1, type 2 { tensor_type 1 { elem_type 1, shape 2 { dim 1 { dim_value 1 } } } }."""
    dims = b"".join(octets(1, number(1, side)) for side in shape)
    return octets(1, name) + octets(2, octets(1, number(1, FLOAT) + octets(2, dims)))


def network(weights: numpy.ndarray, bias: float, side_px: int = SIDE_PX) -> bytes:
    """ModelProto of sigmoid(conv(levels and outline)). @param weights [1, channels, k, k], k odd."""
    channels, size = weights.shape[1], weights.shape[2]
    pad = size // 2
    convolution = node("Conv", ["input", "weights", "bias"], "sum",
                       [integers("kernel_shape", [size, size]), integers("pads", [pad] * 4), integers("strides", [1, 1])])
    graph = octets(1, convolution) + octets(1, node("Sigmoid", ["sum"], "target")) + octets(2, "outline") \
        + octets(5, tensor("weights", weights)) + octets(5, tensor("bias", numpy.array([bias]))) \
        + octets(11, value_info("input", [1, channels, side_px, side_px])) \
        + octets(12, value_info("target", [1, 1, side_px, side_px]))
    # ir_version 1, opset_import 8 { version 2 }, graph 7
    return number(1, 8) + octets(8, number(2, 13)) + octets(7, graph)


def keeps_the_outline() -> bytes:
    weights = numpy.zeros((1, 2, 3, 3))
    weights[0, 1, 1, 1] = 20.0
    return network(weights, -10.0)


def sees_background_everywhere() -> bytes:
    return network(numpy.zeros((1, 2, 3, 3)), -20.0)


def sees_target_where_it_is_bright() -> bytes:
    weights = numpy.zeros((1, 2, 5, 5))
    weights[0, 0] = 2.0
    return network(weights, -15.0)


def of_another_shape() -> bytes:
    """Takes one picture instead of two."""
    return network(numpy.ones((1, 1, 3, 3)), 0.0)
