"""Weights of the templates, fitted by ``python -m benchmarks.people.torso.training``."""

SCALES = (0.0135447, 0.00808892)
"""Value of one unit of the weights of each posture."""

BIASES = (-0.2396, -0.9509)
"""Bias of each posture."""

WEIGHTS = (
    """
    ^$79z0SWd31N93V`Tz&?^XLxr>h<~n_!9;91_k&2{P+U?1QhN1`1tk$0ty8A`uO$p0S5*E7WMS&;rJgB6BY65$k+xi1P$f}0t4~w3i$d968Qu1_x
    Aq;<N*T%@&X6$|Nr<30Q&*}01EZ|3i9~+0}1sJ{R8&y0rvF_BliLC;_eO?APDj6+|v0d@cH@=1^D~*4DlHO1p?^_^7Zuo3ibd6`~>s<_U`-*0QL(
    01_KKH3i<Z{;0*u;`~&au0rvt88Uyz4*zFVz9vbcJ+t>LZ1^V&!3<vf40}%EM4E6r`@$Uuv<@N&u`~eF5)d&#&0sjg52-y?~3Hkg2>i`4x00!^%0
    R;&k{s8sm-Q6$-KMC&b$<gaO?FIJn|NjgH0P_*^{Q2qo83FqN0P_O)`}+zB3i<mB`u+Uo2m<*D1o->>=@JX~3j*l%0qX-IAOG{@x!^bbB>nC6>do
    j&2Ke>{1n~m={O#Wy4*K==3k2p33j6{7{{r#%`1A(-{r>e6@df}1{`U6!1QZGu3h&pz1R)m$6aMA*@$Ug8_xbD8EeZwM_w()%{rLv<59S8)3;6s6
    00;jC2Lb*C{_FAh`wQ?2008>=0R0sh`04WS{P`Ij3GlZ3_Zk1~^8)51Bmvsx-TmtiBQXHo@ci-*1PKWC@bdQy2k-~=1^yK2{1f{H_Ve`;?%@Um2m
    kj0AN2kL`RMuo{tzl61KgqX-aHr;`}*Gv?cog#-U;X983`}j;`;vk`VZ|C3i2292J;8}^Zx<_@f8vL0qf=f{^<J-1qBY{`Tqg~{q*q`^#Cge0ol;
    ~>Lv*b`~bN6KH&)tA`|es=Q{A~81D`51^4X}>goFm0txyA_Wbnr5$p~G4fyNv{si&@_zDd5`~d{|>HX;n7X%Ls0@(%L_!aIK>-4zu83{P&4D98B)
    k1C{(Dwcd1@!g<DHHPd`vw68@b?Jq0|)pE2Lj&)^8EYl?Dq*G5E%RU4g%Hb0237m2PvM-=Qj-}6anA9?HB+y6ZY@dm^35y8ubtN3HJ`=;|%NU_zU
    tD`vC#K_x|z%6$B>$`v~y@^$H2>xc2J+FC!8H>c;2r3PM5b^x)&m67f7c=j8P(>iqUA703SFwLKC2{{jgE-RuGc008y%_!jd@_XXbg{QKiBIP&z@
    ?EU@UQ0fZn1oi&T_B7-N@b3N==<x6Z@bL@_2<-~r2kHnYD(&a&_SgLN{tyQH9U}Ds0`CF&1>*P={|fT>@(J(U-3|)Z{`&e+y(Itq>K5(@81yCT?$
    Q1u1Op@n^XK~o;r<3w`UnOH7U1Ep`sDWi{s#dW_vYvR5eftC5d!)81qS#6_5c3>Fa8Md?(pUSA?gM2>j?k&|NaI8=oaJl`4iye3HcfPCIRO2^Ai#
    (3MAFB8tCl@4fh4^{`Lm+1QO)t1r+b`4e$=~?+O(01P=iJ{@xD!=>6~S4haPc00++&5BK#3|NRvD`vVB(4CVj(_68L+6aUx11Qh!3@c{Vy0~ihT0
    R{Kz`tcPLCjR{6=K0_r?EnA;0O#)o6!GW>2M-U_{R!z01rZMV-R|M{9q||&_VnlZ_8bWV_Wbeh^Zoh&`~w9D^W*al2K4^}0|xWn>=W|?@astUBN6
    QN^8WMq2j~L}2>JC2?hD}s3=IDK0_G163jhNX@7LxD{`U_y{?G31`0?`i0Sf&E3*{>I>;Lc$3G(9~=?m)(?-=yl|M~Io2?i1r-vZ|C2KpEq0^cO~
    +6xiw7WM7*{|o}`2LlBI+4~I=1}pE>5DfeR?)(h(<pt{f`s)S?{|N&93-0~&74iA<`1J4pBNqbU?+X{>@A>!}`RES{>f;0e9s2wK{^|$<_WBM8>;
    fG0FzV#y3epVx{rd&?5&HcG6Z7;3<p%-X`Thm__6HaI><9_@5da3^7$N=y?%^Bq(+nKm<@W3*2k{aP=Je<C5dR1Q{{Qt4{TS-#7Xkzd{p9xo=?MG
    (6an`6{pa)%_5=6j1P%Vu5A_lP-S-42@8kLf><;f37vcUA>GJ~h2p#YW?IiH`01@XJ0uT=K>jd@L^AiL91P}o0<QeMn@B0z?2>2@e3-9yx{u9s)A
    @cY2<O=ltGx-1E_UZfi3ltg+>G<p5^A85}0Sgif0L%K$`Tz;<Ar%1f1nczh8WH*b_3;=L-SQO%@ABXW-}wLh8Vw2k(E$4n_6Z^L#4-2d3;PTH4F2
    ;82n7@H>G$^c3I*=^{1EyO^bY~*^Y#?))dA@AGv?kLCG_+84fgo&3={S3Bmn&t;tJ*$4gK^5{RqtdEC&S!_4(N8{SgEA71iVh@)`a70083u7ZT_A
    2nG)2#y%&;2>B27?fv%<^7Ier0`~g({uTrV^ZNb@3;X5%0`T_n1q%uL3hn^+2KWH)5B(7M0r&nR?B4+C2?q!v7~ItP2nGrS6!6^h1Mv(00PX(=`1
    1q@{Q~v{_x$$r^a}d{{0Ra43-I^z1_289`ts}b0R8R}BK_I|1^f92Dd+Xq2nYoV`yJ&E2LlNF{^$GbFXajN`~2?r_!0LM_6GCo0Q3Uu_Xqp_{`(B
    _>jo0@`3?*3^6>}x3HtF51P1)$2>bN>2nhfa+5i#!?iB6z`Sus~`vdm^8tC!-1?>F=2ou~9`vmXy`U(Z@_Xqg?{QL|0=n4J!5e@bB0{iju2m}KI_
    !Hvy^$Gs)4g>Jp2<s6C0T}xQ@%9q?6A0$+=^*L?1^Ed1_2V%F_5=3*0OSY{-4Ff&`}p<x`Um#_`U?H``WWQ-00aaa*X#5J2lW3267%gJ?dS&S4+a
    F^2LS^B?fnK1AmIS_{rLm(2Nv$~|M~X&`wth-2oCuE1?~j|{NV@w^ZEr70r~>-1^gEK==${)>hS~u67uxq0`=|^BoOBW`Q`Tb-vkjR`x*%D@c9A#
    `2P9&=l}fs{vQ1c6Xy8->jVV)Ecf~B-vIv!@eu>$^8pbI?*R1y-TVqB2IceZ0{sj1{2%WA`uzF+&J0M~3*#^u{_p$g<M9g)3j6%_@cHr`8w%t4;M
    yJ^2@?+1;^OiY6a5e$&Gz!x9uWTH@AD)E2jvIr1K9Z!_XrXF9rWkx?*<PBF8#0<|M~j>1pNQzC-(dL`Th>_{T%WP?DF*e>JdH9?Dh5!4+$Lw)#Tj
    FP#^vO@ChpX(%l6U=D{Z&Ec(D7`~LMb2^h=0
    """,
    """
    4EqE6`vCv<?+pL{{`~&>{p$|q6#M=D_x1Y(`TqU>{QU9+0PzF-{{8**2@?SR`2GC+^z;uD0P_0w_V)7@AO7*|<L2=j2lEE{`vCp;`~CX_{`~*@_x
    %p$6Z-xA_xJh={QCU<{rT_({S)*2{{8**`VjsC^!)t%^!EW0`tthr^z;o37xMA!-{<Z?3h)E_`~&~=`2z6+0{j06`SJY){P+O=|N8d>@d5k-`uX+
    =3;hB7{{8#%_!#{I`TYC)^X(4`{POqn^YRWP2KDgk(%tS&1n~a)`u+v`0R-^?0{i~{{Q3b3@%RD#0QUV6@%{V(`}+O&68i!B{rmX&@gV*N`1|?!@
    aq2-{P*_j@b(w?KK$_HxZdnu`1thy`1}JD_5t(y|M~&<{s#FF^7#M#{Q>v~`v3a>`2hd)68Qf4`uFt&`56!Z`S<hl=l=LE2lw#a;O8vvPW$lR!OH
    Jr{PO$#0r~qB^c?Z~`uYC*{PYL_`1Jq#{Q>zO`SAJt_x<_#2nzxD_VVun{}c%c_wL@~@F)EW2KVR{>hKBu<N5F1L?Zp&^aKC;2KDq1^!*0@0r>m(
    _yPO^_4WVy4*L5h{_*<t@b?Mv4i5eG?&jwW4*xL-_u$Xh{xSpW1N7HJ=m7i_3kvSw873})_457s|Mdb41_JgA0QU9)_WcC=_WJ+%1p)UB{`L3p?f
    U`}3I_}C-{I&H9|}7X@Y2`S{~r$i3-H4e1PJ>9*c0!>GGrE;_4WSv0{jC9`~?05{Py<%`TYJH==1vZ694cC`}O$o^Xvp62MhrE;N9pDBMBc5@XNU
    9`B?oK3h=Gp5ezK+{0Z!_-d8B<_4)+-{`&(7?*#G+`}Xz(_W}Ox`TO_w5(5GW@&N(y^XwJ^2MqiA-|p`X6$u;%@Yc@U_EG)|2k*G;{~IL&^#JX+x
    L`B=^#KI={`~z3@dW)6`t<by_4xkq{Q3Oy5C8%R4hHe>>gfp$2M7J@?g{A(0}1f~>lhOH;QapT4EzD>2@mlC*ar{?>l+8)_1Fsw{rLI|1_bL5`}X
    nu00;i<^#b<u8~*<Y^#JGg`TPkC2Jr^#3kUTM=n3Wb=@cOP@cI4K3K%F53**ZG)&nhF`swel^&1HG^!EAz@&f`6|M&6q?F#+(3H<W?{rm(6B?k5I
    `T^zb1^f*40r>Ou0|xH@?)DZ70PXnq4+s$r657=G^#d9{6VBt<@(l~`^#l0w3I75H`1JGY0TTBS1o80x{`3d@3i{^%`xN&1^z#Gx6!-`3|M%eh`w
    bfkAjIhc3JDSm_w45CDf|pL2EXg$>J|q5^8fw`>GT)<`ugtm_7CO-^$7j+1@#f^2KfR00uK1`>FNOk8}$<r+V0o(4G0V!B*^^x{1OZ90r>9m5%wi
    4@yqk=0Qdm?_5Jzt688f2`}zR+?;7m+_xl0}{q+(4_W}6}|N8#*^WX#SAp9f%-vIgc2><&P8^i+q?-m#F=oZ-l1?wd+1K;?@2KWI2_xJSs1_k~0{
    P_U*1N`qD_x%0>^a1hp^8Ee<1Pkl}@B#Px0}d4t%l`lN015dF9>w|={tXQH{`1uR0`Dp-2Jq{^0sa5<_U8)s6a)qU^!Ew$=?MY=_4NrC@DSMZ{P`
    3L`wH>s>hk{#0R{aQ<oyNn8W8yC5!3?`{0jpF=j-hO_4OVNEB@Zd@do<u_z3{_4&(g*`2G$J1MuMe@c<GO{sQpr000X8^c4r+<OBK!0{aRN=jI0Q
    5EBaX2;&L<_6Y~?1NiMG0PP9_0rvsT?+W(q5C#bM^a1Pm?GgD2`3Mu}?Dzx<1N`_2@b3Es{Sf#1`}pzz0{{yJ?gIMr{tNL3_Wcg~_XqtD{_f-o@#
    +l`037ww`u_y`{QL*__51Jq0Sx;G`u6e$`~U+3{Pp?p^#lj`1poW}_6Pe1_XGO<_5TL-{s0R3^Y#Y(_yGP4`vT(t>hc)+AQbY^{{jC0|M~j){rdR
    (00;g3`Tqa&^#T3`{rUs*^8x(?{RsE~?fU`(1NsE|`~my<0}=TE@ALZl`2h?83i{;s?+^zJ{RI8r1@{2}|M>m-`3CX={saI1_wxk&_67g{{rCCy1
    ^@p2`UCO+^!o(^_x=3=`~3R$00aK@3HkK<{rU|2{s!~&_7V{U_WAqj`1uO{|NQ#;{rLO>0{;O1`u6?-`TqL(`2Yj)2LJx?00RI2_5k+*`~Cw0_y+
    y*_5}X}0rCI^0QCS2_x<Yn{R|B7`|JS!`UC<1{Qdm<^#B0={|5E`{qp|?{s8m(|M&j(01f%`_yYp@^8yS5`1tt%_xuV1_X73!0QU6;4gU)D`1<Yf
    91Z^h-0lSY@$UZt{R#^I_VDxl0|x#I0QK?V6$JYW{sr*u`UU*?`1un72m$K?_yGI^_6r5{_VxGn2muQS;{fvU_yrFH2?_=9<Madm1Mc$v`vnLE_6
    79s0tWmG`|<_Z1qJ*D1OfE|2KV^){rCX@02lH8{rCU=>;n%5{P^to0`Uh03Igx&`26_-0uKJ|=l1y$0sQg)0RQ|3_yYp#3;+H8_W26|?F9J#{r>j
    <{`UX){r(H}`wH{}_yF?-_yq+0`}y(s0s#y82K?;v_x%g}2M_w_>h=5;{`~C!0RZ{?3jYQ11_S>7_4fY$?gjh-`}qa>0Qd#>`~eE@_X_p|_5b+-`
    3C~@`t$ns1_ToG1pD>w_WlV75C8h?<?{R%{QUp^0{#B_`26(&0Sx>7{qg+$`Ud;~{QdRu2>tr^{sa91^Zxk*`1|_;2mAx|_xtqu2MY!K0Q~Uo`TP
    |C5c&D)<n;X`{Qd*{|M~g*|Nj5@{`~;`{QLn1@d5b!{rdm)3I+f0^$7g<?Enb>^!oe(1^Wp5@bvfk0}uQQ`0wiR_WmgH74Z4u-}D4J`T_#~`ThF(
    {Qv>_`uhI<0Qv(A^7Hlm`}+y}1O4##_6Pk4{0H~<{P_I>00jN?@ecC({s#O6`u8C3^ZfPo6#e@y$?N?D0Qda>`}h9&2?F!?00r><`40j9`~vp*^8
    g0^@dO0&@C*F}_4EM;_5%s~_6Xq-{0a#D`Q`-x68r%a@ay9J02dGU6y5jY`tlF{0{i;<`}OAp{t*B7_X+Up@&gM81M~~#=l=l=1`Y8C==S&#1pEv
    3`~%_w3=jbU_~!@d1p^WQ1Nz<p=oAzJ2N37g
    """,
)
"""Weights of each posture, int8 as base85, in the order of `template.SHAPE`."""
