"""Robot WebSocket, which speaks rosbridge: sessions of clients, their calls and goals, and what is sent to them."""
