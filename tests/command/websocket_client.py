"""A WebSocket over a raw socket, which says also what no library would."""
import base64
import os
import socket
import struct


def request(port, lines, timeout=15):
    """Sends the lines of a request as they are; the socket."""
    connection = socket.create_connection(("127.0.0.1", port), timeout=timeout)
    connection.sendall("\r\n".join(lines + ["", ""]).encode())
    return connection


def read_head(connection):
    """The head of a response: its status and its text."""
    data = b""
    while b"\r\n\r\n" not in data:
        more = connection.recv(1)
        if not more:
            break
        data += more
    head = data.decode("latin-1")
    return (int(head.split()[1]) if head else None), head


def upgrade_request(path, host, protocols, origin=""):
    """The lines of a request for a WebSocket; without origin or protocols where these are empty."""
    lines = [f"GET {path} HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
             "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
    if origin:
        lines.append(f"Origin: {origin}")
    if protocols:
        lines.append(f"Sec-WebSocket-Protocol: {protocols}")
    return lines


class Closed(Exception):
    """The server closed the connection, with a code or without one."""

    def __init__(self, code=None):
        super().__init__(f"closed with {code}")
        self.code = code


class WebSocketClient:
    """A client that was let in. `receive_buffer`: a small one makes a client that does not read felt soon."""

    def __init__(self, port, lines, protocol, receive_buffer=None):
        self.connection = socket.socket()
        if receive_buffer:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        # As browsers do it: what is small is sent at once.
        self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.connection.settimeout(15)
        self.connection.connect(("127.0.0.1", port))
        self.connection.sendall("\r\n".join(lines + ["", ""]).encode())
        status, head = read_head(self.connection)
        if status != 101:
            self.connection.close()
            raise Closed(status)
        assert protocol in head, head
        self.data = b""

    def send_frame(self, opcode, payload, final=True):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([(0x80 if final else 0) | opcode])
        head += bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536 else \
            bytes([0x80 | 127]) + struct.pack(">Q", size)
        self.connection.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def _need(self, size):
        while len(self.data) < size:
            more = self.connection.recv(65536)
            if not more:
                raise Closed()
            self.data += more

    def receive(self):
        """The next message: its opcode and its bytes."""
        self._need(2)
        opcode, size, offset = self.data[0] & 15, self.data[1] & 127, 2
        if size == 126:
            self._need(4)
            size, offset = struct.unpack(">H", self.data[2:4])[0], 4
        elif size == 127:
            self._need(10)
            size, offset = struct.unpack(">Q", self.data[2:10])[0], 10
        self._need(offset + size)
        payload, self.data = self.data[offset:offset + size], self.data[offset + size:]
        if opcode == 8:
            raise Closed(struct.unpack(">H", payload[:2])[0] if len(payload) >= 2 else None)
        return opcode, payload

    def close(self):
        self.connection.close()
