"""A client that means well: it asks every ten milliseconds, whatever the server does meanwhile.

    good_client.py PORT    # until its input ends; then prints [[due, seconds], ...] as JSON

`due` is by the monotonic clock, which all processes share; an answer's time counts from then.
"""

import json
import socket
import sys
import threading
import time

import raw_http2 as h2

INTERVAL_S = 0.01
WINDOW_UPDATE = 8


def main():
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    answers = []
    with h2.Connection(int(sys.argv[1]), timeout_s=30) as connection:
        # Two small writes in a row would wait for the other side's delayed acknowledgement.
        connection.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        due, stream = time.monotonic(), 1
        while not ended.is_set():
            time.sleep(max(0.0, due - time.monotonic()))
            frames = connection.call("GetServerInfo", stream=stream)
            assert any(frame.kind == h2.DATA for frame in frames), "no answer"
            answers.append((due, time.monotonic() - due))
            read = sum(len(frame.payload) for frame in frames if frame.kind == h2.DATA)
            connection.send(h2.frame(WINDOW_UPDATE, 0, 0, read.to_bytes(4, "big")))
            due, stream = due + INTERVAL_S, stream + 2
    json.dump(answers, sys.stdout)


if __name__ == "__main__":
    main()
