// The WebSocket to the server (the messages are described in alight/view/protocol.py), opened
// again whenever it closes.

import { frameOf } from "./frames.js";

const SOONEST = 250, LATEST = 4000;

export class Connection {
  // `on` has functions state(object), pixel(object), refused(object), frame(object) and open(bool).
  constructor(on) {
    this.on = on;
    this.wait = SOONEST;
    this.open();
  }

  open() {
    const address = new URL("socket", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.wait = SOONEST; this.on.open(true); };
    this.socket.onmessage = ({ data }) => this.receive(data);
    this.socket.onclose = () => {
      this.on.open(false);
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LATEST);
    };
  }

  receive(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      this.on[message.is]?.(message);
      return;
    }
    this.on.frame(frameOf(data));
  }

  send(word, keys = {}) {
    if (this.socket.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify({ do: word, ...keys }));
    }
  }
}
