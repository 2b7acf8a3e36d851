// Unity: a component that raises an event for every key frame. Not run here: there was no Unity.
// Start: mossar run SOURCE --to osc://127.0.0.1:9000   Add it to a GameObject, and listen to Confirmed.
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
        if (Text(packet, ref at) != "/mossar/key_frame") return;
        var arguments = new List<object>();
        foreach (char type in Text(packet, ref at).Substring(1))
        {
            if (type == 's') { arguments.Add(Text(packet, ref at)); continue; }
            var four = new byte[4];
            for (int k = 0; k < 4; k++) four[BitConverter.IsLittleEndian ? 3 - k : k] = packet[at + k];
            at += 4;
            if (type == 'i') arguments.Add(BitConverter.ToInt32(four, 0));
            else arguments.Add(BitConverter.ToSingle(four, 0));
        }
        // performer, status, kind, take, frame, time, decided_time, velocity, strength, rev
        if ((string)arguments[1] == "confirmed")
            Confirmed?.Invoke((string)arguments[0], (string)arguments[2], (float)arguments[5]);
    }

    static string Text(byte[] packet, ref int at)
    {
        int end = Array.IndexOf(packet, (byte)0, at);
        string text = Encoding.UTF8.GetString(packet, at, end - at);
        at = at + ((end - at) / 4 + 1) * 4; // filled up with zeros to a multiple of four bytes
        return text;
    }
}
