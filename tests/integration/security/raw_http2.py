"""HTTP/2 by hand: one socket, frames as bytes, and nothing that a library would not let through.

    with Connection(port) as connection:
        connection.send(headers_frame(1, request_headers("ListScenes"), END_HEADERS))
        connection.send(data_frame(1, message(b""), END_STREAM))
        frames = connection.read_until(lambda frame: frame.ends_stream)
"""

import dataclasses
import socket
import struct
import time

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, RST_STREAM, SETTINGS, PING, GOAWAY, CONTINUATION = 0, 1, 3, 4, 6, 7, 9
END_STREAM, ACK, END_HEADERS = 1, 1, 4
SERVICE = "/penumbra.v1.PenumbraService/"


@dataclasses.dataclass
class Frame:
    kind: int
    flags: int
    stream: int
    payload: bytes

    @property
    def ends_stream(self):
        return self.kind in (DATA, HEADERS) and bool(self.flags & END_STREAM)


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def integer(value, bits, first=0):
    """HPACK's integers (RFC 7541 §5.1)."""
    most = (1 << bits) - 1
    if value < most:
        return bytes([first | value])
    out = [first | most]
    value -= most
    while value >= 128:
        out.append(value % 128 + 128)
        value //= 128
    return bytes(out + [value])


def text(value):
    value = value if isinstance(value, bytes) else value.encode()
    return integer(len(value), 7) + value


def header(name, value):
    """A literal without indexing, and without Huffman's code."""
    return b"\x00" + text(name) + text(value)


def request_headers(call, *more):
    fields = [(":method", "POST"), (":scheme", "http"), (":path", SERVICE + call),
              (":authority", "localhost"), ("content-type", "application/grpc"), ("te", "trailers")]
    return b"".join(header(name, value) for name, value in [*fields, *more])


def message(payload, is_compressed=False):
    return struct.pack(">BI", is_compressed, len(payload)) + payload


class Connection:
    def __init__(self, port, timeout_s=10.0, greet=True, acknowledge=True):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=timeout_s)
        self.buffer = b""
        self.acknowledges = acknowledge
        if greet:
            self.send(PREFACE + frame(SETTINGS, 0, 0))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, data):
        self.socket.sendall(data)

    def read(self):
        """The next frame; None once the connection is closed. Answers settings and pings."""
        while True:
            if len(self.buffer) >= 9:
                size = int.from_bytes(self.buffer[:3], "big")
                if len(self.buffer) >= 9 + size:
                    kind, flags, stream = struct.unpack(">BBI", self.buffer[3:9])
                    found = Frame(kind, flags, stream, self.buffer[9:9 + size])
                    self.buffer = self.buffer[9 + size:]
                    self.answer(found)
                    return found
            try:
                more = self.socket.recv(65536)
            except ConnectionError:
                return None
            if not more:
                return None
            self.buffer += more

    def answer(self, found):
        if not self.acknowledges or found.flags & ACK:
            return
        try:
            if found.kind == SETTINGS:
                self.send(frame(SETTINGS, ACK, 0))
            elif found.kind == PING:
                self.send(frame(PING, ACK, 0, found.payload))
        except ConnectionError:
            pass

    def read_until(self, is_last):
        """All frames up to one that `is_last`, or to the end of the connection."""
        frames = []
        while found := self.read():
            frames.append(found)
            if is_last(found):
                break
        return frames

    def seconds_until_closed(self, limit_s):
        """How long the other side keeps the connection; None: longer than that."""
        start = time.monotonic()
        try:
            while time.monotonic() - start < limit_s:
                self.socket.settimeout(max(0.01, limit_s - (time.monotonic() - start)))
                if self.read() is None:
                    return time.monotonic() - start
        except TimeoutError:
            pass
        return None

    def call(self, name, payload=b"", *more, stream=1):
        """A unary call; its last frames."""
        self.send(frame(HEADERS, END_HEADERS, stream, request_headers(name, *more)) +
                  frame(DATA, END_STREAM, stream, message(payload)))
        return self.read_until(lambda found: found.stream == stream and
                               (found.ends_stream or found.kind == RST_STREAM))
