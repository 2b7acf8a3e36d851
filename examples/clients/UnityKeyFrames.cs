// Unity: a component that raises events for key frames, moves, activity, steps, followed moves and poses. Not run here: there was no Unity.
// Start: mossar run SOURCE --to osc://127.0.0.1:9000   Add it to a GameObject, and listen to its events.
using System;
using System.Collections.Generic;
using System.Net;
using System.Net.Sockets;
using System.Text;
using UnityEngine;
public class UnityKeyFrames : MonoBehaviour
{
    public int port = 9000;
    public event Action<string, string, float> Confirmed; // performer; onset, offset or minimum; time in s
    public event Action<string, string, string> Moved; // performer; name of the move; limb (with --moves)
    public event Action<string, bool> Active; // performer; whether the body moves now
    public event Action<string, string, string> Stepped; // performer; strike or off; left or right (with --steps)
    public event Action<string, string, string, int, float> Followed; // performer; status; name; count; progress (with --follow)
    public event Action<string, string, string, float> Posed; // performer; entered, held or left; name; seconds
    UdpClient socket;
    void OnEnable() => socket = new UdpClient(new IPEndPoint(IPAddress.Loopback, port));
    void OnDisable() => socket.Dispose();
    void Update()
    {
        var sender = new IPEndPoint(IPAddress.Any, 0);
        while (socket.Available > 0) Receive(socket.Receive(ref sender));
    }
    void Receive(byte[] packet)
    {
        int at = 0;
        string address = Text(packet, ref at);
        var arguments = new List<object>();
        foreach (char type in Text(packet, ref at).Substring(1))
        {
            if (type == 's') { arguments.Add(Text(packet, ref at)); continue; }
            var four = new byte[4];
            for (int k = 0; k < 4; k++) four[BitConverter.IsLittleEndian ? 3 - k : k] = packet[at + k];
            at += 4;
            arguments.Add(type == 'i' ? BitConverter.ToInt32(four, 0) : (object)BitConverter.ToSingle(four, 0));
        }
        string S(int place) => (string)arguments[place];
        float F(int place) => (float)arguments[place];
        // performer, status, kind, take, frame, time, decided_time, velocity, strength, rev
        if (address == "/mossar/key_frame" && S(1) == "confirmed") Confirmed?.Invoke(S(0), S(2), F(5));
        // performer, status, name, limb, take, start, end, decided_time, score, rev
        if (address == "/mossar/move" && S(1) == "confirmed") Moved?.Invoke(S(0), S(2), S(3));
        // performer, channel, state, take, start, decided_time, previous
        if (address == "/mossar/activity" && S(1) == "body") Active?.Invoke(S(0), S(2) == "moving");
        // performer, status, name, limb, joint, take, count, progress, then tempo, certainty, deviation, score, times, id, rev, limbs
        if (address == "/mossar/follow") Followed?.Invoke(S(0), S(1), S(2), (int)arguments[6], F(7));
        // performer, status, name, limb, joint, take, start, seconds, then deviation, decided_time, id, rev, limbs
        if (address == "/mossar/pose") Posed?.Invoke(S(0), S(1), S(2), F(7));
        // performer, status, side, take, time, decided_time, confidence, x, y, z, id
        if (address == "/mossar/step") Stepped?.Invoke(S(0), S(1), S(2));
    }
    static string Text(byte[] packet, ref int at)
    {
        int begin = at, end = Array.IndexOf(packet, (byte)0, at);
        at += ((end - at) / 4 + 1) * 4; // filled up with zeros to a multiple of four bytes
        return Encoding.UTF8.GetString(packet, begin, end - begin);
    }
}
