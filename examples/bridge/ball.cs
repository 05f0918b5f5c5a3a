// A ball above a plane as the physics of `tactor bridge graph.yaml`; messages are packed bytes.
using System;
using System.IO;
using System.Net.WebSockets;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

// Implicit Euler: m (v' - v) / dt = k (x_D - x - dt v') + b (v_D - v') + the force of the plane.
class Ball {
  const double Radius = 0.004, Mass = 0.05;       // m, kg
  const double Stiffness = 2000.0, Damping = 2.0;  // N/m, N s/m, of the plane
  const double Substep = 2.5e-4;                   // s

  double[] p;
  readonly double[] v = new double[3];

  // A step and its result lie as docs/howto/bridge.md has them.
  public byte[] Step(byte[] step) {
    ulong id = BitConverter.ToUInt64(step, 8);
    double span = (BitConverter.ToInt64(step, 24) - BitConverter.ToInt64(step, 16)) * 1e-9;
    double[] from = Numbers(step, 32, 3), handle = Numbers(step, 144, 3), coupling = Numbers(step, 256, 2);
    if (p == null) p = (double[])from.Clone();
    double count = Math.Max(1, Math.Ceiling(span / Substep)), dt = span / count, push = 0;
    for (int i = 1; i <= (int)count; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        double way = handle[axis] - from[axis];
        double pull = coupling[0] * (from[axis] + way * i / count - p[axis]) + coupling[1] * way / span;
        double momentum = Mass * v[axis] + dt * pull, resistance = Mass + dt * coupling[1] + dt * dt * coupling[0];
        v[axis] = momentum / resistance;
        if (axis == 2) push = PushUp(momentum, resistance, dt);
        p[axis] += dt * v[axis];
      }
    }
    var bytes = new MemoryStream();
    var result = new BinaryWriter(bytes);
    result.Write(2u);                 // a result
    result.Write(1u << 1 | 1u << 3);  // gives tool and contact
    result.Write(id);
    result.Write(0L);                                          // time
    foreach (double number in p) result.Write(number);         // p_WT
    foreach (double number in new double[] {1, 0, 0, 0}) result.Write(number);
    foreach (double number in v) result.Write(number);         // v_WT
    for (int i = 0; i < 3 + 6 + 2; ++i) result.Write(0.0);     // w_WT, felt, the force along x and y
    result.Write(push);
    for (int i = 0; i < 3; ++i) result.Write(0.0);             // the torque
    result.Write(0L);                                          // contacts
    result.Write(0L);                                          // bodies
    return bytes.ToArray();
  }

  // The force of the plane, which only pushes, and with it the speed along z at the end of a sub-step.
  double PushUp(double momentum, double resistance, double dt) {
    double depth = Radius - p[2];
    double speed = (momentum + dt * Stiffness * depth) / (resistance + dt * Damping + dt * dt * Stiffness);
    double push = Stiffness * (depth - dt * speed) - Damping * speed;
    if (depth <= 0 || push <= 0) return 0;
    v[2] = speed;
    return push;
  }

  static double[] Numbers(byte[] bytes, int at, int count) {
    var numbers = new double[count];
    Buffer.BlockCopy(bytes, at, numbers, 0, 8 * count);
    return numbers;
  }
}

static class Program {
  // One whole message; null where the run is over.
  static async Task<Tuple<byte[], bool>> Receive(ClientWebSocket bridge) {
    var message = new MemoryStream();
    var piece = new ArraySegment<byte>(new byte[65536]);
    while (true) {
      WebSocketReceiveResult got = await bridge.ReceiveAsync(piece, CancellationToken.None);
      if (got.MessageType == WebSocketMessageType.Close) return null;
      message.Write(piece.Array, 0, got.Count);
      if (got.EndOfMessage) return Tuple.Create(message.ToArray(), got.MessageType == WebSocketMessageType.Binary);
    }
  }

  static Task Send(ClientWebSocket bridge, byte[] bytes) {
    return bridge.SendAsync(new ArraySegment<byte>(bytes), WebSocketMessageType.Binary, true, CancellationToken.None);
  }

  static async Task Serve(string url) {
    string[] parts = url.Split('#');
    var bridge = new ClientWebSocket();
    bridge.Options.AddSubProtocol("tactor.bridge");
    bridge.Options.AddSubProtocol("token." + parts[1]);
    await bridge.ConnectAsync(new Uri(parts[0]), CancellationToken.None);
    await Send(bridge, BitConverter.GetBytes(4u));  // from now on steps are packed
    var ball = new Ball();
    while (true) {
      Tuple<byte[], bool> message = await Receive(bridge);
      if (message == null) return;
      if (!message.Item2) continue;  // the greeting, and a step that came before our request
      if (BitConverter.ToUInt32(message.Item1, 0) == 1) {
        await Send(bridge, ball.Step(message.Item1));
      } else {
        int size = BitConverter.ToInt32(message.Item1, 4);  // behind it is the name of the field
        Console.Error.WriteLine("the bridge refused a result: " + Encoding.UTF8.GetString(message.Item1, 12, size));
      }
    }
  }

  static void Main(string[] arguments) { Serve(arguments[0]).GetAwaiter().GetResult(); }
}
