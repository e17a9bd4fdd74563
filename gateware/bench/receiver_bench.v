// receiver: up to four good packets wait with their content; corrupted ones are counted; packets for other devices
// and replies are ignored. INFO of version 1 is recognised. The fuzz test covers more.
`include "check.vh"
module receiver_bench;
    `include "bench.vh"
    reg         reset = 1, valid = 0, framing = 0, done = 0;
    reg  [7:0]  data = 0;
    wire        ready, good, spoiled, by_line, broadcast, old_info;
    wire [7:0]  old_seq;
    wire [7:0]  packet_type, packet_seq, read_data;
    wire [31:0] arguments;
    wire [9:0]  length;
    reg  [8:0]  address = 0;
    receiver receiver (
        .clk(clk), .reset(reset), .valid(valid), .data(data), .framing(framing), .address(3'd3),
        .ready(ready), .broadcast(broadcast), .packet_type(packet_type), .packet_seq(packet_seq), .arguments(arguments), .length(length),
        .read_address(address), .read_data(read_data), .done(done),
        .good(good), .spoiled(spoiled), .spoiled_by_line(by_line), .old_info(old_info), .old_seq(old_seq)
    );
    integer goods = 0, spoils = 0, lines = 0, olds = 0;
    always @(posedge clk) begin
        if (good) goods = goods + 1;
        if (spoiled) spoils = spoils + 1;
        if (spoiled && by_line) lines = lines + 1;
        if (old_info) olds = olds + 1;
        if (old_info) `CHECK("INFO of version 1 counts as spoiled", spoiled, 1'b1)
    end

    // A packet with this number of bytes before its CRC, generated from a seed; odd seeds give many zeros.
    reg [7:0] body [0:1023];
    reg [7:0] to = 3;
    integer   i, j, at, from, at_all;
    reg [31:0] crc;
    task make(input integer bytes, input [7:0] seed);
        begin
            for (i = 0; i < bytes; i = i + 1) body[i] = seed[0] && i % 5 == 2 ? 8'd0 : seed[0] ? i * 7 + seed : (i * 7 + seed) | 8'd1;
            body[1] = to;
            check(bytes);
        end
    endtask
    task check(input integer bytes);
        begin
            crc = 32'hFFFFFFFF;
            for (i = 0; i < bytes; i = i + 1) begin
                crc = crc ^ {24'd0, body[i]};
                for (j = 0; j < 8; j = j + 1) crc = crc[0] ? (crc >> 1) ^ 32'hEDB88320 : crc >> 1;
            end
            {body[bytes+3], body[bytes+2], body[bytes+1], body[bytes]} = ~crc;
        end
    endtask
    // INFO of version 1.
    reg [15:0] old_crc;
    task make_old(input [7:0] kind, input [7:0] seq, input integer bytes);
        begin
            old_crc = 16'hFFFF;
            for (i = 0; i < bytes; i = i + 1) begin
                body[i] = i == 0 ? kind : i == 1 ? seq : 8'd0;
                old_crc = old_crc ^ {body[i], 8'h00};
                for (j = 0; j < 8; j = j + 1) old_crc = old_crc[15] ? (old_crc << 1) ^ 16'h1021 : old_crc << 1;
            end
            {body[bytes], body[bytes+1]} = ~old_crc;
        end
    endtask
    task put(input [7:0] value);
        begin
            {valid, data} = {1'b1, value};
            @(negedge clk) valid = 0;
            @(negedge clk);
        end
    endtask
    task send(input integer bytes);
        begin
            from = 0;
            while (from <= bytes) begin
                at = from;
                while (at < bytes && body[at] != 0 && at - from < 254) at = at + 1;
                put(at - from + 1);
                for (i = from; i < at; i = i + 1) put(body[i]);
                from = at == bytes ? bytes + 1 : at - from == 254 ? at : at + 1;
            end
            put(0);
        end
    endtask
    task counts(input integer g, input integer s, input integer l);
        begin
            repeat (3) @(negedge clk);
            `CHECK("good packets", goods, g)
            `CHECK("spoiled packets", spoils, s)
            `CHECK("packets spoiled by the line", lines, l)
        end
    endtask
    // The first waiting packet is the one of this seed.
    task take(input integer bytes, input [7:0] seed);
        begin
            make(bytes, seed);
            `CHECK("ready", ready, 1'b1)
            `CHECK("the header", {arguments, packet_seq, packet_type}, {body[6], body[5], body[4], body[3], body[2], body[0]})
            `CHECK("for all", broadcast, to == 8'hFF)
            `CHECK("the length", length, bytes - 7)
            for (i = 7; i < bytes; i = i + 1) begin
                address = i - 7;
                @(negedge clk) `CHECK("a byte", read_data, body[i])
            end
            done = 1;
            @(negedge clk) done = 0;
        end
    endtask

    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        repeat (4) put(0);
        counts(0, 0, 0);
        make(519, 1); send(523);
        make(7, 2); send(11);
        make(263, 3); send(267);
        make(8, 4); send(12);
        counts(4, 0, 0);
        // There is no room for a fifth, and the four are unchanged.
        make(263, 5); send(267);
        counts(4, 1, 0);
        // Packets for other devices need no room.
        to = 4;
        make(263, 5); send(267);
        counts(4, 1, 0);
        to = 3;
        take(519, 1);
        make(519, 6); send(523);
        take(7, 2);
        take(263, 3);
        take(8, 4);
        take(519, 6);
        counts(5, 1, 0);
        `CHECK("ready with nothing", ready, 1'b0)

        // A broadcast, then other addresses and replies.
        to = 8'hFF;
        make(100, 2); send(104);
        counts(6, 1, 0);
        take(100, 2);
        for (at_all = 0; at_all < 255; at_all = at_all + 1) if (at_all != 3) begin
            to = at_all;
            make(7, 2); send(11);
        end
        to = 3;
        make(7, 8'h81); send(11);
        counts(6, 1, 0);
        `CHECK("ready with what is for others", ready, 1'b0)
        to = 4;                                         // damaged, so its address is unknown
        make(7, 2); body[5] = ~body[5]; send(11);
        counts(6, 2, 0);
        to = 3;

        make(520, 7); send(524);                        // too long
        make(6, 8); send(10);                           // too short
        make(100, 9); body[50] = body[50] ^ 1; send(104);
        put(9); put(1); put(0);                         // ends within a block
        counts(6, 6, 0);
        framing = 1; @(negedge clk) framing = 0;        // a good one after a framing error
        make(7, 10); send(11);
        counts(6, 7, 1);
        make(7, 11); send(11);
        counts(7, 7, 1);
        take(7, 11);

        `CHECK("what was INFO of version 1 so far", olds, 0)
        make_old(8'h01, 8'd77, 6); send(8);
        counts(7, 8, 1);
        `CHECK("INFO of version 1", olds, 1)
        `CHECK("its seq", old_seq, 8'd77)
        make_old(8'h02, 8'd78, 6); send(8);             // wrong type, length or CRC, or after a framing error
        make_old(8'h01, 8'd78, 7); send(9);
        make_old(8'h01, 8'd78, 6); body[7] = body[7] ^ 4; send(8);
        framing = 1; @(negedge clk) framing = 0;
        make_old(8'h01, 8'd78, 6); send(8);
        counts(7, 12, 2);
        `CHECK("what was INFO of version 1", olds, 1)
        `END
    end
endmodule
