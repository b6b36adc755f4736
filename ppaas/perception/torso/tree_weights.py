"""Trees that tell people from what looks like them, fitted by ``python -m benchmarks.people.torso.training``."""

BIAS = 0.1122
"""Log odds without trees."""

SCALE = 0.00223387
"""Value of one unit of the leaves."""

FEATURES = """
4*^dB4*^dEP6R#$69rQRQw2`}Qw2`}Z~{{W5CKpD5CKjEG6eAfPX$v2Qw2}~Qw2}~&jM2gF9A^nHU-cEj{r{vt^qIs@B%jlQ3cWhPz8_yFah@jPz
6B+4+BsHF#<0EJq0ZUL<J)S5CKmGQw386Qw386QU&h<QUOv0I|c6oQUx#pHU;kiQw386Qw0<SPX*5cHU%^VF98t+&jPOj%K#Gv5Caec@Buyr5CgC
R5Cb#?PXRFn4*^dF&jB$7Qw386Qw2E%00jUAPyz4)A_dR^8wKzJ@B;4wQUoyp3I!VlPz6i`QUm}6?*jY;00r*>1_LJqQw386Qw8w^QU&k=QUOv0P
z5UmPXs6h&jBq2QUwnK2?aC-?g9@3QUp^4Qw2@|Qw355uL4p95Cc*L@&Zr=@B&f=<pKHx9R>CTJq4Np_5>>dQw386HU%yPPz8_z?F1tQ`~>g<&jR
)YAO#}@00qzjZvoH(&;j%W&jC>cF#$^iP5_YsM+6525CiT3uL6z&vH}wWJq0ucE(KBrNCi9vj{r3V9tA!H8wEoJHw7C790gMaQw2}~PytN>umVm5
Pz6o|kO2P#Km{uWE(J6NF99$GZvjmN&;jfOaRLzoP6BTNPXx{auL2JPZvxE%4+F0OuK_RtPz6f_QU#9!k^wyhPX$v2Qw25!QUxypI|Tp$Qw386Q3
XQ<{{)W$uL4j7Py~<zkpe#jF9A>lA_Y?g9tBbbQUw_WwgCVI5d};E9t9l*MFao<Qw2E%Hw8Wg`vm?3008a;PXP`BZUQ_7?*vW-5Caec@BtJ9@B#1
vF9I(G5Cb*^kOC|MPXSN`&;pVI&;srOF$ItUZ30sTJq1q!Zv#LD-2yrVQw1IcHU;hh7zH~8MFj>0BL#>95Ca|skpKVy`UG$SEdg=@&;c(3001ckP
X(0&(g1G&1_b~BPz6o|PXlfOQUXo|GzG5$4+F9SuLA7?dIB5-`UErug#j-GHU&un002(`Zvm|Uj{;Ny&jAtvQw3H8Qw5I$KLt1iHw6F%4+Ad&j{@
uhM+5)>&jM`%&jIoT&;s}b&jL^dPy|o`GzB>YPz5joA_eXNIR%aau>$b|Z~;*QPXa9h&jHT?PXe|8G6hfpF9dM{I|VugPz5;!KLxM>kO1=pF#>J^
@d5DyZUS)v@B%IYQUwMDPX&qta074yDFpxkaRLehaRM0yKLv3CE&`4MR{=BykpfWyP60LrHw7F8Zvig_wgR#P6$Ksz7zG>!90eW)Fafmz{{$cf`U
DUIw*qPcNCdC~umY_D4FXI8<N`qjDh00s&;zdm?*Xj?0021!J_R=gZ~#FC5dk;_`vmm_I|cd#`vmm_jso!k0|n0ljR8^vzyhlPQ3O{6P6Q$aP6SQ
_Zvs&T6a&!$&jL;YJOwocQw0wLPy!AE{RHp<Pz6#2@B~r?It5PzI0aAvHw6m=PXP}D>jCQli2(@((Euy~Q2|y0F$4t#`~(XHr~*(0assXbtO3#hj
{tE1Ed@^m@c^v>QUo;wO$00jEd@;kR0MPZZvg25ZvYAfZvk%sBL%PmSp={G&;eco008j;Q3CG*u>z3+u>wc|Q3MDDOaxE`>i}f}Z~~D6NCB<_ZUP
Mf?g69#QUx~!QUy>2001xqGzI<y_XPU{_5}U}_XPF?YyuAhZ2}Vl?*VZFZ2|8B&;lU^&H?ZNQ3MhK9t9i)It3O59t9r-^#KP3Oa;*cN&`9tXaE2J
@B;1v3I*)~asvMZ008;~kODUWQUwqK3<CfFA_eXO9R*GT&H<JI8U-!^?Eta?(E!f?%>gzAQUy>2Pz6o{Jq1$*8vzal{{+hd3IqBCFagg1QUy{4QU
w429R)N6GzBIFAO$Z2Pz5*vwgUhFF9Od2&jE`9tpLLSF9LJ{8wIZc&H#D>F9I(D=mgIKEd=fXZvp@S002D&3<Ep`H3d-xLIsZk4+BvGEd>$-asm$
m008O%>H?4gQ2`7Ci2`r|QUwwPQUx~!008a;Pyx~bvH_0*k^&M1`~mL)`vms{^aODN`vmj^ZURsORsw4QECNshPyy8eJq6DJuK`m9&;!r{j{#8yP
5=M}Fac5pQw25!5dzTyZ2}(!(E|GfI|UsD3k5X<(E&09&H(@b5CbX&3<Hq?PXn|9QUuNbO#xB`&;qRiZvZz1P6bW{&I2?9Jq0rb3I$OFJOxw)5Ci
Z5umT(fQUy{4kN^MxIt35_QUy{4Hw94zHU&=sKm`*6Q347BQ34JE?gViG4g&B3F9rVuM+G(oPX!zWashM#$^lFQ&;n8dkpcMxP68?c4g)d*`2qj{
z5p!+RRVJYQvnbG(Ew2eK?Owx5(RJoI0a4xK?OAhP6c5DEdp->HU*CYZvl@1uK}+CuK}+C3I#0%ZvjmN&;uX=uL4m55dw1p3<K~0(*X|xQw3H8P6
9{(EdUe)tO7IzNCA-mQUN#t_XITsbOHJVbOQJU_ykP>bOQ1L(gF_yPy!DFvH}kR9R*GTLIutNYyuAg008p=v;n*V9R<+<k^<8L?f@<U5&`W1Z2|5
84FM1X4h0Yblmc-AQUd@0Pz6r}ECkO2`~>g=Oa!n32L&4i5Cic8iUP3$>jWbOZ~;CAZ~>SA00903Py$H-&;n2b%mDxZI0aAvPytW`5CKvFIRz&LY
XNox%K=LQ00000Z~}4y1OgHQF9OE^$N}*Iu>#QnkpZv*=>RSPZ33_X5CRYa5CX6P_5@J{Py$i}LIp$u5&~5KQ3O#0Oa$%$u>wd0O9To75CO;n5CO
0O3<44X5e3i!@d3~Q&;jlQ&I0@d{RH|1^#m*d4goy{NCi0sIR$h9kOBYz00005_5m;fwgGPfqX7T_90fB28wJk-Ed^fz001unDFqq@O9iw800000
5dx6{4gwJa@d5Y*JOwKR2n7lSN(J!)Ed}ue5Cbj+`2w*5P67=BZvhbkkpe9O9|f`k_yj)%BLzDJumTPP5Cd@m006Q95&}{J?g6p^PXQGIE(K5pkp
OT5j{pn;001KefB+Z*kN_<OdjbFe`veLD^aQa2lmhew{Q~d-Zvig>kO6Q2L<Ld=F9lKsQvgr_F9K8pIRy{`FapB?Z~<@utO5=KQUy{4Py`bN&jPd
o5Cb>`Z~|}v{RBt_Km%|BbO8?lEd>t%&;V2fEd|d3&jQZ^PXf;Z&jRlPFapp4Y5|S{@BsA$3IebJI|VxhLIw8(Zvc(~DFgroP6Y7*4g*aD`vf@!J
_U~g&jJhr0s;U4R|5qFR09wKC<RdkJ_U0EvjSKGQ3A38vH=<e`2-^cnF2)x9tENS001Bb7zMNeAO#==4g+uj`~>|3s{!={`ULs}$^aDu&jL>Z^#b
n!i2*qU5Cd`obprANF9HbzD+ICuasg5T4gog;aRQJ63I%QgCj@Q*ZUIjLM*<H5P6As3{RC?Qu>z3+4+75u+yT%5@&Yje@&Hf;Q3Njp&H_sWZvi<4
QU!?u90m6T$pI7t(E>aL$^kqD@d5w<K?PC*>H(?&N&-p(IR!cakOJ!jAq8&%qyR1g007Se4+AR%Pz4kOPz8qq002@24gv`Ut^$q$PX#ap5dyIRu>
l<gasjac9t8&lJO$4KYXR;8Ed>AouLAA?PXTKJZUIjMMg=1UF9omyNCi#;@d5w<FamM{!~qfl4gvrG006E63<CB9i~`I8_5=U`69TgV`2jEj_5h3
l4*~ZCJO%UwvjOk|008p=D+IUz4*@*^{{-#=I|Z)-ItA|mL<P_SQ3de;BLzAIP6Rmx@Bt12Sp-N0*a83m)B@81000000tHY7iUU;xrU5Dd001ims
{tAT4Ff9z5d;7LZ31ZmZ31lqZ36BAFal8n0|hMwP6O@$O#=V`Pz5gpHUzQ)&H--#76TIl5d#ndBL#5+69O^;ZvsC7I0ZHZQUW#wkO8RztO7&=X#z
$CPy+b`YXSKLuL1f5Wdg4PF9K5q?*Y#Ndjhlq&jQZ^4h8Z7u>sNo(gHOFI0QojJOEGxK?VB+asnR(P6h7*6a}sViUR8c*#Slci38395CLuikO5Ey
QUwzQA_WWq009348U?ZePXbZ`s{wifPy%xTjskB1ZvhYiuK}+C&jAVr5Cu;JQUwtLEdfIWy#Nve76lmt9tH6L?*KFclmd?eQvw_XFanYS@B#S*Zv
hShP5}S_I|We$Py{mpRRlo+u>u_hECtyEF#$9L4*@O&KLw-!X#s8mX#q(BPz8<yQ34wR69TaUF#>i1PXZAF5d-l8_5o4_@d7Ua3k7Zg5(CZw&H(@
b008v?)dEiev;h+XP625GDFiG7QUweGEd)CS4gviH_5}6>{RI64FahlWECP)INdid%Yyk=d&;mULkOKMy7z0rP_XPF?ZvyTD5(6v*%mP~iSORPUt
O2Y6_yi0AtO0NW?gSA5Oae;<kpTbz^8_XU4*(DW4*>N6Fa<0D@B)MY{{(0ON(1%--T?&!Mg{o<9|eyB6#{Ysa{_b$69RSua{*2O@c@?sw*k2VRRT
@{%K>o$PzCS<dIHb_umMj48U^eGuL4g6uLAf4i~~Cb&;pPG{se9T)B!UE002@2IR%daKm|_%Z~;;U5Chl(00kTc00plC008U(tO85|s{yY94*`$@
QU%ZgMFr3T4Ffg>&;mpSOa;#ZQUTKduL5lWE(KBrv;yn_@B*#?001lnEdvt-GXekwjRR8w^8u3rvjMaLkOGtflLGMo5CM$=Z~+hk(g3UhZ2~|9_X
I8hPz789?Ez2$R{=5sZ~^cE@&wKTwgR*Q90i#Ilmhkve*%#KaRF`tuL3m!ZUOZHFakCML;_3&l>z_&002<}SOYx;?*x?t3j^%}tN{}RECTNYlK|N
OP6AH?&jQZ^5CRhe007SdEClTWF9huZ=K?MSumSM|Fah}lFagd2ivlnKO#}}FF9Om4O#}b{i~<h=vH{QnG6K>9Py`zV{sayMN&%4qPysOl00005M
g{HxIt3X64g(GYZ~{;QPy#Ok695eZ&j2C?(E@t`(E{%RuK@r6(gCso6a|t2aRIOa&j9WO>H#hSssa226a|a`^#Qd3Z~=7!xd62SjsYVD83k|wlL8
+F000005(C`;9R(Q!umT?i^a2e9U;(NFs{ud(00000Ed@^m+5t}kPyzG<6#`BK4*^mHECo*i8Uro@w*t2T5CUldw*qnk%mPvcPytZ^Z~;;U%mESu
P6AN^9tE@l?Ex7D83haiYy!{%tO5H2<^j(Eg92g#rvg+0?g0%0P681DGzF0XIt7>l5dlpCassmfZUGhokO6N3ZvyiHvjI~AasnFxCINB+JOz&e@c
@tl76b7BQU(76Jq5D?4gx;~0Rw{q`vg$}jRW%p83myN3I#m{LIu<TI|b_k8wEK9Gy)a_Zvt}y4FMSiFaj+C%>m5;P6CYq3IX^8
"""
"""Feature of each decision, uint16, little-endian, as base85."""

LIMITS = """
2nY`V4g>-U2ml5E2nz@Z4*(7e0tyHK1^@{R2?PQO4FU@Z2?7HQ0tpEM0|W{S3kd`c1P2cS2?q=X4haAc0tgKW0|*HQ4FLiP0tN^J2?-AZ2?YrP2n
-Ac2>=NK1_lWQ4G9DV00{*N1qciY4haDY0uK=f2nPcQ4-N<g3;_}e01^WL3j_fX5()qY3=9zq2LJ>J2oDMm4Fd=g4hjki4GjPa3kCuK0tf^J3J3@
a1qlZU2?hxV2@eSm5D5qZ3JVMf2n-7b0S^KM00jvG2?7NI2?qrL0RjmR0t)~J1pxpC2>=NX1^@^M2nP%Z5C{ki1qcWV0uB-g1^@&O1_A^I4Id2z0
|f^N3<3)b2m}fc2L%TN2nP-c0|*EM4<8T+0tf~L9|Hge2mk^C2nPrN2LcEH2n7fT0Rjd92nqlQ2nYcN3kv`R5DNkc3Jwtj2M`Db10M?p2m=NO9|Q
sr0ssIX0}Brb0t5*S3JD4f5djJY4FCfM9}5fs1_uif0|gEX1_S~L2nh%c3?Bvn1_1*A2m}iW0tE{R1quiV2nY!X2M7oV2mk;83kU!P2?YoU5C8}W
2?+=Z3<wGY0uK-k03QSZ2mt~J2m}BE2n!Gb1q=rO1pojA1qB5F2M!4f2?z!U3=Iki3kMDY1Pu%c2@xL$2LccW00adE1_b~B2nz%X2MhoJ3=s<k2n
Gof00RdB0R#gJ1`hxR0R#XD1_l8P1rY}c5C{+i0RR9H4+IMU1_1#B2LTNb1rQMe3=j_k00j;Q5D@_Y00#*T4habm9|{Nx2nY!Y3<D1V4-N?g00am
D1ONmD2n8Pu0tE#H1px&F00;pK2nYud3IhrX0S5#G1_S^E5CZ}b5djb%5D5Vb2Lm4r1^^ER0Urqo2?z-U2?+uM5C;na69E7a00{&D2@U`W2MGiM2
p<6f0s{*R1O^cw2L}fc000OE1PBlc2nPTL0SE>k9|8ab0|NvI5CH-J2nrt$5D5tm5D5eT2ml`d3k(bj3jhEL1Ox*J000OE1P2NN5D@_Y00|HP2ND
1Q3J(SZ2nYxR3;_lU00{{J2_Fyx5C;tr0|5vR2MG=W2>}Zb00ICE4Gszj3<CrL4Ic*q4-*6f1P28X0RRXH0SE{X009CA1OW#C5e)|i2Mh=X2nZ1$
4FwMf01OZk0RjL300IF52><~G0|*ER2nYlS1po;U4gd)O1PA~K2?zrP0T2NI2muiQ2ml2F2M7iT2nGoY3knDe3JMGX69EVZ9}Eow1P2fd3kePa3l
I<w015yB03QSk5efni4GjYW3K0<s00{^O2nZhw1_lNQ2_FOi2MPcM1_TBT1_mD=4G0bh2ml2M2?+@d0tpBR2nYxW0ul@X01*KJ3kVJi2oDYs2@L@
V0u2KP1qTNL2LuEJ2LJ#K3K9ng2_GK`5dskj5g!Z?4+jAN9}xov0udh{2nYxW0|EmP0RRFJ0ss&I0|WsO2M7oV0}KNP2@VMf3<w_w2L=lQ1`q@R5
fK0h9|;T#5C8%n3IqxV3j_=e4gd@R2MPcL0SE>U1`7xc2nYua5(EqY5D^Rn00#mG0R{#T009UO1qlfW2@C=Y1_lQU00jX60RRF95C;VX3=0SY0}>
7i3I_xq5djbe0S^TT2mk>M2n7rT1_lHM9|Qys0s#pK1OyHQ0t5gB2M7=c5DpLs1_%fZ0R{yD2@3=W1qcub2mlca0So~N2?`4e4GIha00avW3JwSf
5D^9d5D^Ig0s{*l0|*Zf4-f?a2>=TR5eXj(5D^3s0S6xv2mlBO0s#mJ2m=QO1q2NX1`Gfn2M7!a2nPiT00{yC2p<s$5eNt$9}Nox3kv}s4-f(f0S
5^T4Gabh9|8dY5dZ`M1PlQQ015*D2Mz%Y2nrAi03QqsA0Gn*5D^gp9|RE(3=j$*1_lTM0tW~Y0RaOD3m*g!5ef<q5e*6m0tpQf000C53IqoX3IGH
S2nYrR2n7WQ2LlEP4FCxV00{yK2?7EU009C50RjpT0099H1q1;A3jqiR1ON#E9|;Ku3I-7b0|*2O2?+@a2?YZS1O*5L4h{qn1P}@j4G9bf1`rVp0
0;*k1PlrQ5daJW1OfmC4h#qp4-5wn0RaID2mk>J2nYxW5e@?h00;pH2p=C25eE?u0RRC34-W(Y4g>@Q0s#RD2nP-Z2n7lN2m=5J0|N{S0R#;J4+s
ee0t^BO0|@~I2_FRy5DWnW01gfj01g2H0|E#D1PTQL2?q%V2>=ic3;+uV5eNYc5eEtn1^^8L3jqQI5Dftc3j!Ys0SpER4h#?g0R{pK9|#Bt2M7oV
5DEYX2?GfM0R;>I0}uog2n+`d9|8~%4*(Af2nYxV2@41d2?q%Y5Df_p0}cWJ2?q`U3IhNL3=0SZ4-5<k1qT2L1rQMt0|W;j9{~XX0t^8U1_A*C5C
RAc3jqrW9}ol&1_}fN3IhoP2M7iS3<&}d1|JX$2MY%a4FL-P00ajJ9{~gg3IzrR2?+@b000XK5fBOi2p<d#01*iW2?GxW4+a1b4-W?r01XET2?z@
UA0G}71Q7=S5C8xG5da?_1pyBc2L%WW2@e7Z2nh`h2oC}V2oMVq3keYk1`7od1qB2P3knMX0Ra&a4FU)Z2nYcP2LTZa2nGlR2M7rW2nYfI00;mG3
kU-V4habX2nhuc0|*fV0003D3kC}Z0SpfW3JVJY0SE{P1OWgD
"""
"""Limit of each decision, uint8 as base85."""

LEAVES = """
;g>YC_++Vaim1C1`!qsu<*zNrPRy$-p18^l0#!j`?IFf5(>_$>0LdxSx=vFMyWs6R9i3C|z47_9KH{ShuEYJy0zNcSy7&${z34L1zpK*x2RJxV?H
4NP#u$#Y(+<)6I=#>;^(g;5{ICPOz_0Da6x}UK_9VjnLGZ&4{kRB1)SBQs0oOC~0#df<%C+jl{wE$m0J15(`P8%!0?9k@^0mAe#o=E1{VPZn|0di
AJJ{nM03o;}!!WG=+_v!*{3}Ax{uKDOI=~gX4f8SU;k7Qy`!q54<w~d`_7co0HUjC30Wz!I!wsCt)cXhL$}KIw>&^$|_8%e90n+cM57ay4`Y9pc6
u=C|3hFA~@GVWj{@OM6Cji?$_6zB)xE%w@vg#iE1U*Lp&+h@&>@PF6_6!KF{xMnnw&_C!0AIyf1mX|IvhfT6{uKSzFX==8@eI8Z!#KR{_!TMH<uK
X^^%Mgl`@hr-{>>WU=pFkY&kOzAP!kXN1McRt07gR-{thM4t>ORx12!T25Vsxx0ptHG<E|nA_zCv37w=Qm{4go--A0<>1J|PMuiPR44Elc(QP>*R
$n?_}0`Ley_6`^Cw*D3X=O79&{YvZv1MBdx4bnpb{uJOR^CZa`1~~%e?;TM7^a{lh-U_=Y{5KX$`5@i|`!hAu-z3&P|HuhH>8~6B>LB?g=pp<x_7
@%B|1h!k1KIPgMe#4#{Yc|iO6=)2{tB?@=_$7C0qOrS+(hx8{|~(ty9qe}`71CE^Qce>{zvau{Xydc3H-1J$p}i*0p$Zb;4iuV1@a&S!xzT@(;v+
)0519p?66SZ_*DKO{Szty0#fnD02BV=x*0LU{R{53?6Vuw1KUU1<tI1p0^;p7<`wd*1;-Lv;{-3${|?6uw(k!B_Zubo4bwlw{}ItC?KZ0g@f9fr0
3Q70w)P$XLBs;`{yX|o5nM;)`Pn)73ql9_0_r63vFzP0|1I!LI0f~>0MpSO#U4Wd{3Q7!z7j(K67CrM<f;Dv`3ofG<|+NS|278LI{V=i0LQ`)=se
38{Ra)g0JkvT8vwQK|40Mz{|v<gvH~gq_8>$5KK$|m{V)G2`Zp)z0T?R$@Bp>|%oZQ){yF*x0Vnwe#1KIM{0}ks4d^uOv)&T`{Ym~4{}ojD58p!J
`3vk$13Bsi3-0<$0XqBG?I+M8#QGEe{Td?e;S;+M0O}y&9`g=F1NZH@y73GE2mQ`S62PF}3H>hq^CHRs|HsJ>!S&Ng{uLtf9mMj#8UXIN0NgO;0X
iG#D(27y>mDHV@)!L#03O>Eybm_;|KJ({82ugF_!j*zxcCYH{s_wy4%yWG&jkMw(HO??$@M(_4FJdi@hm0r`z;~w0o4a#zYkI8_!Lq2^(Ffw(gqp
Q`x^NL{}w9#;2qr!1V%63C-vU{`Uxq<3f?@y1u^*s?6(2{1otBC{2&9}0p%$0>m2>E`2rKZz6Tos{uKGZ083{q01weQ4!Q=I`~<!P-!rZN0xJ3h!
to6N{Vz8J^gPq}{|*`Uz5w(9`WXBpw)-sC{vIRGGR^5A{TL4D`6U2D^8>&O_p%q_0qsNp@i-K}{_Y?40y71|_758QJ=o0t0^n8`O#kl<1N;AtwgB
${0WkC$y7m<S2L9G7=dtww01?Y4uK)@F_7~tL7WU3O036>n;WtAM2>uw}6~5@D0`48!5A+B({R$Vx+77n>1L6%uK>Gjd|H=RtxB&+M021d6{<jDK
1^EFS>N&y>06ItB{xq}g0ly3X71GQ5`4AKLz!5al!y^LT<|0Vn&H)3(FYyuS1J6qd`qCNf{U<8g^+VMW1lUgl{u4Cx)C}JT%M=a%0`AuX`5^z){|
)aT<{_E@3jh?w+A0gl3HBl5G!Oa@{|Gkk<E;z;1orqq?+;n&01^01IrCZU0x=l&1L7Rl`V;*h9mur%{u>NL06g{u_!|=Sz57z(21EM>$s#Gr|L7L
x9>y}y{tfcH`Wt8Z^#>L4?g}Hp0Mx(${4f0l{~|~VF7oaZ0`$xa900WZ{}$*Q^sO8K`x6-Y@FWP*0PrsQ|3CoP0{Ifh@w^}a`w}k#7y3N_02LeM)
EKY;`xF2nx&Q$H|1Aye<Sdy0{0CCv9qZ#71p5)V0s!{1{TK4IA_Xbb-Tna>6S+0l0q-9A!5{Z3`6~wX#{d8T|JVT_^|K%V0PidQ#T6g`1>^%&81e
fY0T#_10Ki57{Rz?`{y9es0`@TaHR;_X(<UFx0WT5q{R<n$3NQJl06h66_$V3b!u8Vx02mMD{}~JK+ZeX@=>Zq?2(A|F2L2b$zXkgu`4}_{1RUcY
>Ae{M0pSP90vOyQ>MrmA1|JID`Wq+W+W`vJ%oXfb0S)`M;s+=0|05fnChjx&{sqYYApp7S{}M6(Ezb4D01^AUyAb&^0PrOP>I|;<1svBk_6PnN{_
f`?2{iI5`wAcS`~bfI{~#pq{xSv90rbiJ*c1lP1o!zqG~N5o{uS#A5YGA_+!gc2|1cc-{tX@W;w!KE1M@QM2R!)=0pJ_(K>*bc0NyY44Alk1{s`R
v!ul=d0{0E!zY_}V{S)X6F5~<q{uLnWEBNvO1^LM${3{MT02B+!%@W}p{sz7gxDOZr-?$6u06g1W0OAPw!3Pci{^&pYEB*Zr1^ON0#1{eT{N3|71
tI_%1NsZvyZrzF1NjKe;5J4S{^ud*D+3Pu{uL$L@f^+t{^a{3?+iBv|0wG!Lj~{({S7t?5%>Os=K>Ny03-e60r1TUw*dD52i`dG(*6MN1wP#)G~e
|F0Oc6j7y!Qx{t+4D2|M~L0qy`T|3M1Z{}cZ<x&ZAE02KQX)+zNt1^y1p!|w|K{tNpd$NN40|KvF6JOukX{|m?e!}JOO|0Gra=M2mb0VDb`H|f<3
{~0~{GX4bR{RY)7zyJvV01M^>&jj|Y{0trf1OUhY|Hcjd!U#U=0qZCH?kT_f{0am&5%2#h04&rt`XRm~1RvTW{xmP~|0F2b3GT@*1^nCv8r$^>1^
e9rE%o#-03HnS`V}bT1obcYF#huc7~RJW0U!?E`vfBayzJ#5`W@sE^#Z^f{~i9^7~&-V{}T<@>j2|01ocP)H~jy}
"""
"""Leaves, int8 as base85."""
